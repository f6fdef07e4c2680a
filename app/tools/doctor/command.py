"""``brickpose doctor``: runs all checks one after another, and prints the verdict."""

from __future__ import annotations

import sys
from collections.abc import Iterator

from app.console import say
from app.settings.config import Config
from app.settings.profiles import profile_file
from app.tools.doctor import pi
from app.tools.doctor.board import check_board, firmware_image
from app.tools.doctor.computer import check_computer
from app.tools.doctor.finding import PROBLEM, WARNING, Finding, Machine
from app.tools.doctor.robot_check import check_camera, check_profile
from robot.description.spec import RobotSpec


def doctor(config: Config, machine: Machine | None = None) -> int:
    """Check the machine, and the robot if it is ``buildhat``; return 1 on a problem, else 0."""
    result = []
    for finding in _findings(config, machine or Machine()):
        say(str(finding))
        result.append(finding)
    say(_verdict([each.level for each in result]))
    return int(any(item.level == PROBLEM for item in result))


def _findings(config: Config, machine: Machine) -> Iterator[Finding]:
    yield from check_computer(config)
    if config.robot != "buildhat":
        return
    yield from pi.check_pi(machine)
    yield from pi.clock(machine)
    yield firmware_image()
    of_wire = list(pi.check_wire(machine, config.build_hat.serial_port))
    yield from of_wire
    spec = RobotSpec.load()
    if pi.usable(of_wire):
        device = pi.device_of(machine, config.build_hat.serial_port)
        yield from check_board(device, spec.joints, config.build_hat, _tell)
    yield check_profile(profile_file(config), spec)
    yield from check_camera(spec.lens, config.camera)


def _tell(text: str) -> None:
    """Print to standard error what a check waits for, so that the report stays clean."""
    if text:
        sys.stderr.write(f"         ... {text}\n")
        sys.stderr.flush()


def _verdict(levels: list[str]) -> str:
    problems, warnings = levels.count(PROBLEM), levels.count(WARNING)
    if problems:
        return f"{_number(problems, PROBLEM)} to solve, {_number(warnings, WARNING)}"
    return f"No problem, {_number(warnings, WARNING)}"


def _number(count: int, noun: str) -> str:
    return f"{count or 'no'} {noun}{'' if count == 1 else 's'}"
