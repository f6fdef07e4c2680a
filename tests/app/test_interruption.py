"""What a signal does to code that cleans up, and to code that drops exceptions."""

import os
import signal
import subprocess
import sys
import threading

import pytest

from app.command_line import main
from app.interruption import Interrupted, deferred, interruptible, uninterrupted
from app.settings.config import ROOT


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_interrupts_and_gives_the_exit_code_of_a_shell(number, code):
    before = signal.getsignal(number)
    with pytest.raises(Interrupted) as ended, interruptible():
        os.kill(os.getpid(), number)
        signal.pause()
    assert ended.value.code == code
    assert signal.getsignal(number) is before


def test_code_that_drops_every_exception_does_not_drop_the_interruption():
    with pytest.raises(Interrupted), interruptible():
        try:
            os.kill(os.getpid(), signal.SIGINT)
            signal.pause()
        except BaseException:
            pass
        signal.pause()


def test_what_is_dropped_at_the_end_is_raised_there():
    with pytest.raises(Interrupted), interruptible():
        try:
            os.kill(os.getpid(), signal.SIGTERM)
            signal.pause()
        except BaseException:
            pass


def test_an_exception_that_c_code_makes_of_the_interruption_is_the_interruption():
    with pytest.raises(Interrupted) as ended, interruptible():
        try:
            os.kill(os.getpid(), signal.SIGTERM)
            signal.pause()
        except BaseException as error:
            raise SystemError("returned a result with an exception set") from error
    assert ended.value.number == signal.SIGTERM


def test_a_failure_of_code_that_dropped_the_interruption_is_the_interruption():
    with pytest.raises(Interrupted), interruptible():
        try:
            os.kill(os.getpid(), signal.SIGTERM)
            signal.pause()
        except BaseException:
            pass
        raise RuntimeError("no compiled object yet")


def test_a_failure_of_what_cleans_up_is_told():
    with pytest.raises(OSError, match="disk full"), interruptible():
        try:
            os.kill(os.getpid(), signal.SIGTERM)
            signal.pause()
        finally:
            raise OSError("disk full")


def test_a_destructor_that_is_interrupted_prints_nothing(capsys):
    class Signals:
        def __del__(self):
            os.kill(os.getpid(), signal.SIGINT)
            for _ in range(1000):
                pass

    before = sys.unraisablehook
    with pytest.raises(Interrupted), interruptible():
        Signals()
        signal.pause()
    assert capsys.readouterr().err == ""
    assert sys.unraisablehook is before


def test_no_signal_interrupts_what_cleans_up():
    cleaned = []
    with pytest.raises(Interrupted) as ended, interruptible():
        try:
            os.kill(os.getpid(), signal.SIGTERM)
            signal.pause()
        finally:
            for _ in range(3):
                os.kill(os.getpid(), signal.SIGINT)
            signal.pause()  # until the alarm, which raises nothing here
            cleaned.append(True)
    assert cleaned
    assert ended.value.number == signal.SIGTERM


def test_a_loop_is_asked_to_end_and_not_interrupted():
    calls = []
    with pytest.raises(Interrupted) as ended, deferred(lambda: calls.append(1)) as asked:
        assert not asked()
        os.kill(os.getpid(), signal.SIGTERM)
        os.kill(os.getpid(), signal.SIGINT)
        assert asked()
    assert calls == [1, 1]
    assert ended.value.code == 143


def test_a_signal_waits_for_the_end_of_what_is_not_interrupted():
    done = []
    with pytest.raises(Interrupted) as told, interruptible():
        with uninterrupted():
            signal.raise_signal(signal.SIGTERM)
            done.append("begun")
            signal.raise_signal(signal.SIGINT)
            done.append("ended")
        done.append("too far")
    assert (done, told.value.code) == (["begun", "ended"], 143)
    with pytest.raises(Interrupted), deferred() as asked:
        with uninterrupted():
            signal.raise_signal(signal.SIGINT)
            assert not asked()
        assert asked()


def test_another_thread_is_never_interrupted():
    done = []

    def work():
        with uninterrupted():
            done.append("done")

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert done == ["done"]


STARTING = """
import signal, threading
from multiprocessing import popen_spawn_posix
from app.interruption import Interrupted, interruptible
from app.worker_process import WorkerProcess

threading.Thread(target=threading.Event().wait, daemon=True).start()  # it takes a signal as well
start = popen_spawn_posix.util.spawnv_passfds

def interrupted(*arguments):
    pid = start(*arguments)
    if "spawn_main" in str(arguments):  # it waits for what it is to be sent
        signal.raise_signal(signal.SIGTERM)
    return pid

popen_spawn_posix.util.spawnv_passfds = interrupted
if __name__ == "__main__":
    try:
        with interruptible():
            WorkerProcess()
    except Interrupted as told:
        print(told)
"""


@pytest.mark.skipif(os.name != "posix", reason="processes start otherwise")
def test_a_worker_that_is_just_starting_when_a_signal_comes_does_not_complain(tmp_path):
    script = tmp_path / "starting.py"
    script.write_text(STARTING)
    environment = os.environ | {"PYTHONPATH": os.fspath(ROOT)}
    done = subprocess.run([sys.executable, script], env=environment, capture_output=True, text=True,
                          timeout=90, check=True)  # fmt: skip
    assert (done.stdout, done.stderr) == ("ended by SIGTERM\n", "")


def test_without_a_signal_nothing_is_raised():
    with deferred() as asked, interruptible():
        assert not asked()


def test_the_command_line_ends_with_the_code_of_the_signal(monkeypatch, capsys):
    def interrupted(parsed):
        raise Interrupted(signal.SIGTERM)

    monkeypatch.setattr("app.page.run_options.config_from", interrupted)
    assert main(["run"]) == 143
    assert capsys.readouterr().err == ""
