"""What is done in another way on macOS and Windows, each part of it on this computer.

Whole commands without Unix are in ``test_without_unix.py``.
"""

from __future__ import annotations

import ctypes
import errno
import io
import os
import signal
import socket
import sys
import time
import types
from contextlib import closing
from pathlib import Path, PureWindowsPath

import numpy as np
import pytest
import yaml

from app import console, files, operating_system
from app.features.course.sandbox import limits, student_process
from app.features.course.sandbox.custody import Usage
from app.features.course.sandbox.student_process import Limit, StudentError, StudentProcess
from app.features.course.sandbox.windows_custody import (
    Accounting,
    BasicLimits,
    ExtendedLimits,
    JobError,
    WindowsCustody,
)
from app.features.course.source import read_source
from app.features.own_models.model_file import ModelFile
from app.features.recordings.library import RecordingError, rename
from app.features.recordings.replay.parts import _names_file
from app.files import atomic_file
from app.interruption import Interrupted, interruptible
from app.result_files import is_portable
from app.settings.config import ROOT, load_config
from robot.errors import PortError
from robot.hat import serial_port
from robot.hat.serial_port import SerialPort, find_device
from robot.hat.wire.windows import WindowsWire
from robot.settings import SettingError

unix = pytest.mark.skipif(sys.platform == "win32", reason="uses what only Unix has")


def test_no_second_program_takes_an_address_on_windows(monkeypatch):
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(socket, "SO_EXCLUSIVEADDRUSE", -5, raising=False)
    asked = []
    listening = types.SimpleNamespace(setsockopt=lambda *option: asked.append(option))
    operating_system.claim_address(listening)
    assert asked == [(socket.SOL_SOCKET, -5, 1)]


def test_a_file_that_another_program_reads_is_replaced_a_moment_later(monkeypatch, tmp_path):
    monkeypatch.setattr(sys, "platform", "win32")
    tries, replace = [], Path.replace

    def refused_twice(new, old):
        tries.append(new)
        if len(tries) < 3:
            raise PermissionError(13, "The process cannot access the file")
        return replace(new, old)

    monkeypatch.setattr(Path, "replace", refused_twice)
    with atomic_file(tmp_path / "kept.toml") as new:
        new.write_text("new", encoding="utf-8")
    assert (tmp_path / "kept.toml").read_text(encoding="utf-8") == "new"
    monkeypatch.setattr(files, "PATIENCE_S", 0.0)
    tries.clear()
    with pytest.raises(PermissionError), atomic_file(tmp_path / "kept.toml") as new:
        new.write_text("newer", encoding="utf-8")


@pytest.mark.parametrize("name", ["con", "NUL", "aux.1", "com7.mcap", "lap.", "LPT1"])
def test_names_that_windows_has_for_devices_are_refused(tmp_path, name):
    assert not is_portable(name)
    folder = tmp_path / "lap"
    folder.mkdir()
    (folder / "lap_0.mcap").write_bytes(b"no magic")
    os.utime(folder / "lap_0.mcap", (1, 1))
    with pytest.raises(RecordingError, match="Windows takes no file of the name"):
        rename(tmp_path, "lap", name)


@pytest.mark.parametrize("name", ["console", "nullpunkt", "com", "lap.2", "com10"])
def test_other_names_are_taken(name):
    assert is_portable(name)


@pytest.mark.parametrize("name", ["..\\evil.py", "C:evil.py", "C:\\evil.py", "..", "a\\..\\b"])
def test_a_name_in_a_recording_leads_out_of_no_folder_of_windows(name):
    assert not _names_file(name, PureWindowsPath)
    assert _names_file("square.svg", PureWindowsPath)


@unix
def test_a_model_with_a_drive_letter_is_a_file_and_a_class(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    Path("C:\\me\\model.py").write_text("class Model: ...", encoding="utf-8")  # a name, on Unix
    found = ModelFile.find("C:\\me\\model.py:Model")
    assert (found.path.name, found.class_name) == ("C:\\me\\model.py", "Model")


def test_settings_from_windows_editors_are_read(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text('map = "town"\r\nport = 9000\r\n', encoding="utf-8-sig", newline="")
    config = load_config(file)
    assert (config.map, config.port) == ("town", 9000)
    file.write_text('map = "Küche"\n', encoding="cp1252")
    with pytest.raises(SettingError, match=r"no text in UTF-8: save it as UTF-8"):
        load_config(file)


def test_a_file_that_cannot_be_written_is_named_as_its_owner_named_it(tmp_path):
    path = tmp_path / "table.csv"
    with pytest.raises(OSError, match=r"'[^']*table\.csv'$"), atomic_file(path) as new:
        raise OSError(errno.EROFS, "Read-only file system", str(new))
    assert list(tmp_path.iterdir()) == []


def test_a_students_file_from_windows_is_read(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text("x = 1\r\n", encoding="utf-8-sig", newline="")
    assert read_source(file) == "x = 1\r\n"
    file.write_text("größe = 1\n", encoding="cp1252")
    assert "\ufffd" in read_source(file), "Python refuses it, with its line"


def test_printing_does_not_fail_for_want_of_a_sign(monkeypatch):
    kept = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(kept, encoding="cp1252", newline="\n"))
    console.never_fail_to_print()
    console.say("Größe σ → 3 µm")
    assert kept.getvalue().decode("cp1252") == "Größe ? ? 3 µm\n"


@unix
def test_an_interruption_that_was_dropped_is_raised_again_without_timers(monkeypatch):
    monkeypatch.delattr(signal, "setitimer")
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(Interrupted) as ended, interruptible():
        try:
            os.kill(os.getpid(), signal.SIGTERM)
            time.sleep(10)
        except BaseException:
            pass
        for _ in range(1000):
            time.sleep(0.01)
    assert ended.value.number == signal.SIGTERM
    assert signal.getsignal(signal.SIGINT) is before
    with interruptible():
        pass  # no thread is left that would end the program


class Resource(types.ModuleType):
    """The module, where the system refuses to limit memory."""

    RLIM_INFINITY = -1
    RLIMIT_AS, RLIMIT_CPU, RLIMIT_FSIZE, RLIMIT_CORE, RLIMIT_NOFILE, RLIMIT_NPROC = range(6)

    def __init__(self):
        super().__init__("resource")
        self.set = {}

    def getrlimit(self, limit):
        return 10, 40 if limit == self.RLIMIT_NOFILE else self.RLIM_INFINITY

    def setrlimit(self, limit, values):
        if limit == self.RLIMIT_AS:
            raise ValueError("current limit exceeds maximum limit")
        self.set[limit] = values


def test_on_apples_processors_all_limits_but_that_of_memory_are_set(monkeypatch):
    fake = Resource()
    monkeypatch.setitem(sys.modules, "resource", fake)
    monkeypatch.setattr(sys, "platform", "darwin")
    limits.limit_this_process()
    assert fake.set == {1: (30, 30), 2: (0, 0), 3: (0, 0), 4: (40, 40), 5: (0, 0)}


def test_on_linux_a_limit_that_is_refused_is_an_error(monkeypatch):
    monkeypatch.setitem(sys.modules, "resource", Resource())
    monkeypatch.setattr(sys, "platform", "linux")
    with pytest.raises(ValueError, match="exceeds"):
        limits.limit_this_process()


APPLE = """
import sys, resource, sysconfig, numpy
sysconfig.get_config_vars()
set_limit = resource.setrlimit
def refuse(limit, values):
    if limit == resource.RLIMIT_AS: raise ValueError('current limit exceeds maximum limit')
    if limit != resource.RLIMIT_NPROC: set_limit(limit, values)
resource.setrlimit = refuse
sys.platform = 'darwin'
"""


@unix
def test_without_a_limit_of_memory_the_grader_looks_how_much_is_in_use(monkeypatch):
    monkeypatch.setattr(student_process, "START", APPLE + student_process.START)
    monkeypatch.setattr(student_process, "MEMORY", 250_000_000)
    monkeypatch.setattr(sys, "platform", "darwin")
    source = "import numpy as np\ndef f(a):\n    b = np.ones(5 * 10**7)\n    while True: pass\n"
    source += "def g(a):\n    return a + 1\n"
    with StudentProcess("mine.py", source) as process:
        assert process.fences == ("limits of the system", "Python's own events")
        assert process.call("g", (np.arange(3.0),)).result.tolist() == [1, 2, 3]
        with pytest.raises(StudentError, match="GB of memory"):
            process.call("f", (np.arange(3.0),))


def test_what_uses_too_much_memory_is_ended():
    with pytest.raises(StudentError, match="more than 2 GB of memory"):
        Limit(lambda: Usage(0.0, 2**31 + 1), 3.0).check()


TOLD = [
    (" 12345   0:01.52\n", Usage(1.52, 12345 * 1024)),  # macOS
    ("  2048 00:01:02\n", Usage(62.0, 2048 * 1024)),  # Linux
    ("1 1-02:00:00\n", Usage(93600.0, 1024)),
    ("", None),
]


@unix
@pytest.mark.parametrize(("said", "usage"), TOLD)
def test_ps_tells_what_a_process_has_used(monkeypatch, said, usage):
    from app.features.course.sandbox import unix_custody

    done = types.SimpleNamespace(stdout=said)
    monkeypatch.setattr(unix_custody.subprocess, "run", lambda *_, **__: done)
    assert unix_custody.usage_told_by_ps(1) == usage


@pytest.mark.skipif(ctypes.sizeof(ctypes.c_void_p) != 8, reason="sizes of 64 bits")
def test_the_jobs_structures_are_as_large_as_windows_has_them():
    sizes = [ctypes.sizeof(each) for each in (BasicLimits, ExtendedLimits, Accounting)]
    assert sizes == [64, 144, 48]


@unix
def test_a_student_runs_in_no_job_that_windows_refuses(monkeypatch, tmp_path):
    from without_unix import Kernel32, WindowsPopen, _Call

    kernel = Kernel32()
    kernel.AssignProcessToJobObject = _Call(lambda job, process: 0)
    monkeypatch.setattr(
        "app.features.course.sandbox.windows_custody.windows_kernel", lambda: kernel
    )
    monkeypatch.setattr(ctypes, "get_last_error", lambda: 5, raising=False)
    started = []

    class Popen(WindowsPopen):
        def __init__(self, *arguments, **options):
            super().__init__(*arguments, **options)
            started.append(self)

    monkeypatch.setattr("subprocess.Popen", Popen)
    with pytest.raises(JobError, match="Windows does not limit a student's process"):
        WindowsCustody([sys.executable, "-c", "input()"], tmp_path, {})
    with started[0] as process:
        assert process.wait(10) == -signal.SIGKILL


@pytest.fixture
def windows_port(monkeypatch, pty):
    """A port by pyserial's own waiting, which a pseudo-terminal has, too."""
    monkeypatch.setattr(serial_port, "SystemWire", WindowsWire)
    with closing(SerialPort(pty.name)) as port:
        yield port


@unix
def test_bytes_pass_a_port_that_is_waited_for_without_select(pty, windows_port):
    pty.write(b"P0: +12\r\n")
    assert windows_port.exchange(1.0) == b"P0: +12\r\n"
    began = time.monotonic()
    assert windows_port.exchange(0.03) == b""
    assert time.monotonic() - began >= 0.03
    windows_port.put(b"port 0 ; pwm\r" * 30)
    heard = b""
    while len(heard) < 390:
        windows_port.exchange(0.0)
        heard += pty.read(130)
    assert heard == b"port 0 ; pwm\r" * 30
    assert windows_port.finish(b"stop\r", 1.0)
    assert pty.read(5) == b"stop\r"


REFUSALS = {
    "could not open port 'COM9': FileNotFoundError(2, 'not found', None, 2)": "names one, as COM3",
    "could not open port 'COM9': PermissionError(13, 'denied', None, 5)": "another program has",
    "Cannot configure port": "cannot be opened as a serial port: Cannot configure",
}


@pytest.mark.parametrize("said", REFUSALS)
def test_what_cannot_be_opened_on_windows_says_why(monkeypatch, said):
    import serial

    def refuse(*_, **__):
        raise serial.SerialException(said)

    monkeypatch.setattr("robot.hat.wire.windows.serial.Serial", refuse)
    monkeypatch.setattr(serial_port, "SystemWire", WindowsWire)
    with pytest.raises(PortError, match=REFUSALS[said]):
        SerialPort("COM9")


def test_windows_has_no_port_of_its_own_for_a_build_hat(monkeypatch):
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(serial_port, "other_ports", lambda example: f"as {example}; there is COM4")
    with pytest.raises(PortError, match="as COM3; there is COM4"):
        find_device()


def test_the_public_runners_try_each_system_and_python():
    text = (ROOT / ".github" / "workflows" / "tests.yml").read_text(encoding="utf-8")
    [job] = yaml.safe_load(text)["jobs"].values()
    assert {item.partition("-")[0] for item in job["strategy"]["matrix"]["system"]} == {
        "ubuntu", "macos", "windows",
    }  # fmt: skip
    assert job["strategy"]["matrix"]["python"] == ["3.11", "3.13", "3.14"]
    named = (ROOT / "tests" / "everywhere.txt").read_text(encoding="utf-8").split()
    assert "tests/everywhere.txt" in text
    assert [name for name in named if not (ROOT / name).is_file()] == []
    targets = [line.partition("make ")[2] for line in text.splitlines() if "make " in line]
    rules = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert targets == ["check", "test"]
    assert all(f"\n{target}:" in rules for target in targets)
