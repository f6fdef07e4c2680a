"""Checks of the Build HAT and its motors over the serial port; no motor turns."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

from app.tools.doctor.finding import Finding, ok, problem, sentence, warning
from robot.description.wiring import Wiring
from robot.errors import PortError
from robot.hat.board import BoardDriver, BoardState
from robot.hat.motor import Motor
from robot.hat.serial_link import SerialLink
from robot.hat.serial_port import SerialPort
from robot.hat.settings import BuildHatSettings
from robot.hat.start.bring_up import BringUp
from robot.hat.start.firmware_image import FirmwareImage, FirmwareImageError
from robot.hat.start.reset_line import GpioResetLine
from robot.hat.start.upload import Stage
from robot.hat.supply import Supply

LONGEST_S = 25.0
"""Longest check [s]. The upload (5 s on the wire), the firmware's start and the connection of the
motors take 16 to 18 s."""

WELL_S = 1.2
LOST_S = 1.0
SILENT_S = 2.0
PLUGGED_S = 3.0
CONNECTING_S = 12.0
"""How long to wait for a change [s]. WELL_S: all is well (a power fault is reported once a second).
LOST_S: the port cannot be used. SILENT_S: the board does not answer. PLUGGED_S: a motor is missing
on a board that was already running. CONNECTING_S: a motor is missing after an upload."""

WARM_S = 2.5
"""A board that takes longer to answer has just been started [s]."""

LOOK_S = 0.05

WEAK_V, STRONG_V = 7.0, 9.0
"""A supply outside these limits gets a warning [V]; the board is made for 8 V +-10 %."""


def firmware_image() -> Finding:
    """Check that the firmware for the board is on this computer."""
    try:
        image = FirmwareImage.installed()
    except FirmwareImageError as error:
        return problem(sentence(str(error)))
    return ok(f"Firmware {image.version} for the Build HAT is installed")


def check_board(
    device: str,
    wirings: tuple[Wiring, ...],
    settings: BuildHatSettings,
    tell: Callable[[str], None],
    reset: Callable[[], None] | None = None,
) -> list[Finding]:
    """Start the board as a robot that stands still does, and check its state.

    Args:
        wirings: the joints that should be there.
        tell: called with a text that says what the check waits for.
        reset: pulses the board's reset pin; None: the pin of this Pi.
    """
    try:
        SerialPort(device).close()
    except PortError as error:
        return [problem(sentence(str(error)))]
    board = BoardDriver(wirings, settings, BringUp(FirmwareImage.installed))
    link = SerialLink(device, board, reset or GpioResetLine().pulse)
    link.start()
    try:
        state = _settled(board, link, tell)
        return list(judged(board, state, settings, time.monotonic()))
    finally:
        link.close()


def _settled(board: BoardDriver, link: SerialLink, tell: Callable[[str], None]) -> BoardState:
    """Wait until all is well, or until a problem no longer changes; return the last state."""
    begin = since = clock = time.monotonic()
    answered_after = LONGEST_S
    news = progress = ""
    while clock - begin < LONGEST_S and link.failure is None:
        state = board.state(clock)
        if state.supply_v is not None:
            answered_after = min(answered_after, clock - begin)
        if news != (news := _news(board, state)):
            since = clock
            if progress != (progress := _progress(board, state)):
                tell(progress)
        if clock - since > _search_interval(board, state, answered_after):
            break
        time.sleep(LOOK_S)
        clock = time.monotonic()
    return board.state(clock)


def _news(board: BoardDriver, state: BoardState) -> str:
    """Return a text whose change means that it is worth waiting longer."""
    return f"{board.bring_up.stage} {board.bring_up.trouble} {state.ready} {state.faults}"


def _progress(board: BoardDriver, state: BoardState) -> str:
    """Return what the check waits for, in plain words; empty if it waits for nothing."""
    if board.bring_up.ready:
        return "" if state.ready else "waiting for the motors"
    return board.bring_up.stage.value


def _search_interval(board: BoardDriver, state: BoardState, answered_after: float) -> float:
    """Return how long to wait for a change [s]."""
    if state.supply_v is not None:
        if state.ready:
            return WELL_S
        return PLUGGED_S if answered_after < WARM_S else CONNECTING_S
    if board.bring_up.ready:
        return LOST_S
    stuck = board.bring_up.trouble and board.bring_up.stage in (Stage.ASKING, Stage.FAILED)
    return SILENT_S if stuck else LONGEST_S


def judged(
    board: BoardDriver, state: BoardState, settings: BuildHatSettings, current: float
) -> Iterator[Finding]:
    """Yield the findings about a board's state.

    Args:
        board: the board; its link is still open.
        current: the time now on the board's clock [s].
    """
    if state.supply_v is None:
        yield problem(sentence("; ".join(state.faults)) or "The Build HAT does not answer")
        return
    yield ok(f"The Build HAT answers, with firmware {board.bring_up.version}")
    low = _complaints(state.supply_v, settings.low_supply, current)
    yield supply(state.supply_v, low)
    faults = {motor.fault(current) for motor in board.motors}
    yield from (motor_line(motor, current) for motor in board.motors)
    yield from (
        problem(sentence(fault)) for fault in state.faults if fault not in faults | set(low)
    )


def supply(volts: float, complaints: list[str]) -> Finding:
    """Judge the motors' supply [V], given the driver's complaints about it."""
    given = f"The Build HAT's supply is {volts:.2f} V"
    if complaints:
        return problem(f"{given}. {' '.join(complaints)}")
    if volts < WEAK_V:
        return warning(f"{given}: weak", "charge the battery")
    if volts > STRONG_V:
        return warning(f"{given}: too much", "take a supply of 8 V")
    return ok(given)


def motor_line(motor: Motor, current: float) -> Finding:
    """Check that a joint's motor can be used."""
    fault = motor.fault(current)
    if fault is not None:
        return problem(fault)
    where = f"Port {motor.wiring.port} ({motor.wiring.name})"
    if not motor.is_ready(current):
        return problem(
            f"{where}: the motor does not tell its position", "pull its plug, wait, plug"
        )
    kind = f"{motor.wiring.motor} motor" if motor.wiring.motor else "motor with an encoder"
    return ok(f"{where}: {kind}, tells its position")


def _complaints(volts: float, low_v: float, current: float) -> list[str]:
    """Return the driver's complaints about a voltage that stays the same."""
    judge = Supply(low_v)
    judge.take_voltage(volts)
    judge.take_voltage(volts)
    return judge.complaints(current)
