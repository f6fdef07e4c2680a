"""``brickpose doctor`` on Pis made of files: each thing amiss is a line with its cure."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import fake_gpiod
import pytest
from fake_gpiod import Pins

from app.features.build_hat import pi_check as pi
from app.features.build_hat.machine import Machine, output_of
from app.tools.doctor.finding import OK, PROBLEM, WARNING, Finding, ok, problem

PI_4 = "Raspberry Pi 4 Model B Rev 1.4\0"
PI_5 = "Raspberry Pi 5 Model B Rev 1.0\0"
CMDLINE = "console=tty1 root=PARTUUID=1-02 rootfstype=ext4 rootwait\n"


class Pi:
    """A folder that looks like a Raspberry Pi; its serial port leads to no hardware."""

    def __init__(self, root: Path, model: str = PI_4, port: str = "ttyS0") -> None:
        self.root = root
        self.said: dict[str, str] = {"vcgencmd": "throttled=0x0\n", "timedatectl": "yes\n"}
        self.forbidden: set[Path] = set()
        self.write("/proc/device-tree/model", model)
        self.write("/proc/cmdline", CMDLINE)
        self.write("/boot/firmware/config.txt", "dtparam=audio=on\nenable_uart=1\n")
        self.pins = Pins()
        self.pins.add(self.write("/dev/gpiochip0", ""), fake_gpiod.PI_4)
        self.write(f"/dev/{port}", "")
        (root / "dev/serial0").symlink_to("ttyAMA10" if model == PI_5 else port)
        if model == PI_5:
            self.write("/dev/ttyAMA10", "")

    def write(self, path: str, text: str) -> Path:
        file = self.root / path.removeprefix("/")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        return file

    @property
    def machine(self) -> Machine:
        return Machine(
            self.root,
            run=lambda command: self.said.get(command[0]),
            may_use=lambda path: path.resolve() not in self.forbidden,
        )

    def findings(self, setting: str = "auto") -> list[Finding]:
        machine = self.machine
        return [
            *pi.check_pi(machine),
            *pi.clock(machine),
            *pi.check_wire(machine, setting),
        ]

    def amiss(self, setting: str = "auto") -> list[Finding]:
        return [one for one in self.findings(setting) if one.level != OK]

    def the_problem(self, setting: str = "auto") -> Finding:
        (only,) = self.amiss(setting)
        assert only.level == PROBLEM
        return only

    def the_warning(self) -> Finding:
        (only,) = self.amiss()
        assert only.level == WARNING
        return only


@pytest.fixture
def four(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Pi:
    pi = Pi(tmp_path)
    monkeypatch.setitem(sys.modules, "gpiod", pi.pins.module())
    return pi


@pytest.fixture
def five(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Pi:
    pi = Pi(tmp_path, PI_5, "ttyAMA0")
    monkeypatch.setitem(sys.modules, "gpiod", pi.pins.module())
    return pi


def test_a_line_has_level_finding_and_cure() -> None:
    assert str(ok("Python 3.11.2")) == "ok       Python 3.11.2"
    assert str(problem("No wheels", "buy some")) == "problem  No wheels. Cure: buy some"


def test_nothing_is_amiss_on_a_pi_that_is_set_up(four: Pi) -> None:
    assert four.amiss() == []
    told = [one.message for one in four.findings()]
    assert "Raspberry Pi 4 Model B Rev 1.4" in told
    assert "Serial port /dev/serial0" in told


def test_a_pi_5_is_looked_at_where_its_port_is(five: Pi) -> None:
    assert five.amiss() == []
    assert "Serial port /dev/ttyAMA0" in [one.message for one in five.findings()]


def test_the_debug_connector_of_a_pi_5_is_told_from_the_header(five: Pi) -> None:
    for wrong in ("/dev/serial0", "/dev/ttyAMA10"):
        found = five.the_problem(wrong)
        assert wrong in found.message
        assert "/dev/ttyAMA0" in found.cure


def test_a_console_on_the_debug_connector_of_a_pi_5_does_no_harm(five: Pi) -> None:
    five.write("/proc/cmdline", "console=ttyAMA10,115200 " + CMDLINE)
    assert five.amiss() == []


@pytest.mark.parametrize("console", ["serial0", "ttyS0"])
def test_a_console_on_the_port_is_a_problem(four: Pi, console: str) -> None:
    four.write("/proc/cmdline", f"console={console},115200 {CMDLINE}")
    found = four.the_problem()
    assert "console" in found.message
    assert "do_serial_cons 1" in found.cure
    assert pi.usable([found])


def test_a_console_on_the_header_of_a_pi_5_is_a_problem(five: Pi) -> None:
    five.write("/proc/cmdline", f"console=ttyAMA0,115200 {CMDLINE}")
    assert "do_serial_cons 1" in five.the_problem().cure


def test_a_login_shell_at_the_port_is_a_problem(four: Pi) -> None:
    """The kernel's console is off already, so that switching it off again would change nothing."""
    four.write("/proc/4711/cmdline", "/sbin/agetty\0-o\0-p -- \\u\0--keep-baud\0ttyS0\0vt220\0")
    found = four.the_problem()
    assert found.cure == "sudo systemctl disable --now serial-getty@ttyS0"
    assert pi.usable([found])


def test_a_login_shell_elsewhere_is_none_of_our_business(four: Pi) -> None:
    four.write("/proc/4711/cmdline", "/sbin/agetty\0-o\0-p -- \\u\0--noclear\0tty1\0linux\0")
    assert four.amiss() == []


def test_without_the_port_the_serial_hardware_is_to_be_switched_on(four: Pi) -> None:
    (four.root / "dev/serial0").unlink()
    found = four.the_problem()
    assert "/dev/serial0" in found.message
    assert "do_serial_hw 0" in found.cure
    assert not pi.usable([found])


def test_another_name_than_the_right_one_is_answered_with_the_right_one(four: Pi) -> None:
    assert "/dev/serial0" in four.the_problem("/dev/ttyUSB7").cure


def test_a_port_that_may_not_be_opened_is_a_problem_of_groups(four: Pi) -> None:
    four.forbidden = {four.root / "dev/ttyS0"}
    found = four.the_problem()
    assert "sudo usermod -aG dialout $USER" in found.cure
    assert "log in again" in found.cure
    assert not pi.usable([found])


def test_who_has_the_port_open_is_named(four: Pi) -> None:
    four.write("/proc/4711/comm", "minicom\n")
    (four.root / "proc/4711/fd").mkdir()
    (four.root / "proc/4711/fd/3").symlink_to(four.root / "dev/ttyS0")
    assert "minicom (process 4711)" in four.the_problem().message


def test_our_own_process_is_not_in_the_way(four: Pi) -> None:
    fd = four.root / f"proc/{os.getpid()}/fd"
    fd.mkdir(parents=True)
    (fd / "3").symlink_to(four.root / "dev/ttyS0")
    assert four.amiss() == []


@pytest.mark.parametrize("line", ["dtoverlay=w1-gpio", "dtoverlay=w1-gpio,gpiopin=4"])
@pytest.mark.parametrize("file", pi.BOOT)
def test_one_wire_on_the_reset_pin_is_a_problem(four: Pi, file: str, line: str) -> None:
    four.write(file, f"enable_uart=1\n{line}\n")
    assert "do_onewire 1" in four.the_problem().cure


@pytest.mark.parametrize("line", ["#dtoverlay=w1-gpio", "dtoverlay=w1-gpio,gpiopin=17"])
def test_one_wire_elsewhere_is_fine(four: Pi, line: str) -> None:
    four.write("/boot/firmware/config.txt", line)
    assert four.amiss() == []


def test_a_pi_with_low_voltage_is_warned_of(four: Pi) -> None:
    four.said["vcgencmd"] = "throttled=0x50005\n"
    found = four.the_warning()
    assert "its voltage is too low now" in found.message
    assert "it was slowed down" in found.message


def test_a_clock_that_nobody_set_is_a_warning(four: Pi) -> None:
    four.said["timedatectl"] = "no\n"
    assert "set-ntp" in four.the_warning().cure


def test_tools_that_are_not_there_are_not_missed(four: Pi) -> None:
    four.said.clear()
    assert four.amiss() == []


def test_a_reset_pin_out_of_reach_is_a_warning(four: Pi) -> None:
    four.pins.forbidden = {str(four.root / "dev/gpiochip0")}
    assert "usermod -aG gpio" in four.the_warning().cure


def test_who_holds_the_reset_pin_is_named(four: Pi) -> None:
    four.pins.line("GPIO22").consumer = "lg"
    found = four.the_warning()
    assert "GPIO22 is held by 'lg'" in found.message
    assert found.cure == "end the program"


def test_a_pi_without_the_library_for_its_pins_is_told_of_it(four: Pi, monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "gpiod", None)
    assert "gpiod" in four.the_warning().cure


def test_another_computer_is_no_pi_and_has_no_port_of_its_own(tmp_path: Path) -> None:
    machine = Machine(tmp_path, run=lambda command: None)
    (found,) = pi.check_pi(machine)
    assert (found.level, "emulate-hat" in found.cure) == (WARNING, True)
    (found,) = pi.check_wire(machine, "auto")
    assert (found.level, "--serial-port" in found.cure) == (PROBLEM, True)


def test_a_port_may_be_named_from_where_we_are(tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "hat").touch()
    monkeypatch.chdir(tmp_path)
    found = list(pi.check_wire(Machine(run=lambda command: None), "hat"))
    assert found[0] == ok("Serial port hat")


def test_a_tool_that_fails_or_is_missing_says_nothing() -> None:
    assert output_of(["true"]) == ""
    assert output_of(["false"]) is None
    assert output_of(["a-tool-that-nobody-has"]) is None
