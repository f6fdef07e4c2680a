"""Commands of the firmware: about the board, about driving, and about reports."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from robot.errors import CommandError
from sim.hat.firmware.drive import ControlMode, WaveShape, fixed_point
from sim.hat.firmware.port import Port
from sim.hat.firmware.power import Power, supply_text
from sim.hat.firmware.reports import DEFAULT_PERIOD, Writer
from sim.hat.firmware.variables import MODES, Variable
from sim.hat.plants import PORTS
from sim.hat.words import CommandWords


@dataclass(slots=True)
class FirmwareRun:
    """State of one run of the firmware for its commands; it stays when a client disconnects."""

    ports: Sequence[Port]
    write: Writer
    power: Power
    version: str
    """Number and date of the version."""
    signature: bytes
    """Signature of the running image (64 bytes)."""
    current: int = 0
    """Number of the port that commands act on, until another is named."""
    echo: int = 0

    @property
    def port(self) -> Port:
        """The port that commands act on."""
        return self.ports[self.current]


LAST_OFFSET = 127
LAST_SLOT = 7
MOST_PAIRS = 15
LONGEST_PERIOD = 1_000_000_000

SHAPES = {shape.value: shape for shape in WaveShape}
SHAPE_NAMES = tuple(SHAPES)

Command = Callable[[FirmwareRun, CommandWords], None]


def execute(session: FirmwareRun, words: CommandWords) -> None:
    """Execute the commands of a line; the first mistake ends it, but earlier effects stay."""
    try:
        while words.next_command():
            _command(words)(session, words)
    except CommandError:
        session.write("Error\r\n")


def _command(words: CommandWords) -> Command:
    name = words.choice(NAMES)
    if name is None:
        raise CommandError(f"valid are {', '.join(NAMES)}")
    return COMMANDS[name]


def _help(session: FirmwareRun, words: CommandWords) -> None:
    session.write(f"Commands: {' '.join(NAMES)}\r\n")


def _clear_faults(session: FirmwareRun, words: CommandWords) -> None:
    """Do nothing: the chips forget past faults, and lasting faults are reported again anyway."""


def _port(session: FirmwareRun, words: CommandWords) -> None:
    session.current = min(words.unsigned(), PORTS - 1)


def _list(session: FirmwareRun, words: CommandWords) -> None:
    for port in session.ports:
        session.write(port.describe())


def _light_mode(session: FirmwareRun, words: CommandWords) -> None:
    """Read the mode and do nothing: the emulated board has no lights."""
    words.integer()


def _supply(session: FirmwareRun, words: CommandWords) -> None:
    session.write(supply_text(session.power.millivolts))


def _echo(session: FirmwareRun, words: CommandWords) -> None:
    session.echo = words.integer()


def _debug(session: FirmwareRun, words: CommandWords) -> None:
    """Read the kinds of traces and do nothing: no driver reads them."""
    words.integer()


def _version(session: FirmwareRun, words: CommandWords) -> None:
    session.write(f"Firmware version: {session.version}\r\n")


def _signature(session: FirmwareRun, words: CommandWords) -> None:
    session.write(f"Firmware signature: {session.signature.hex(' ').upper()}\r\n")


def _pwm(session: FirmwareRun, words: CommandWords) -> None:
    """Drive the motor directly by the setpoint, which stays as it is."""
    session.port.controller.control = ControlMode.DIRECT
    session.port.coasting = False


def _coast(session: FirmwareRun, words: CommandWords) -> None:
    """Let the motor coast; the setpoint continues, but has no effect."""
    session.port.coasting = True


def _pid(session: FirmwareRun, words: CommandWords) -> None:
    """Control a variable."""
    _control(session, words, ControlMode.VALUE)


def _pid_diff(session: FirmwareRun, words: CommandWords) -> None:
    """Control a variable's rate of change."""
    _control(session, words, ControlMode.RATE)


def _control(session: FirmwareRun, words: CommandWords, control: ControlMode) -> None:
    """Read a controller's parameters.

    After a mistake, the parameters before it are kept, and the old setpoint drives the motor.
    """
    controller = session.port.controller
    session.port.coasting = False
    controller.control = ControlMode.DIRECT
    controller.variable = _variable(words)
    controller.proportional_gain = words.decimal()
    controller.integral_gain = words.decimal()
    controller.derivative_gain = words.decimal()
    controller.windup = words.decimal()
    controller.dead_zone = words.decimal()
    controller.control = control


def _variable(words: CommandWords) -> Variable:
    return Variable(
        port=min(words.unsigned(), PORTS - 1),
        mode=min(words.unsigned(), MODES - 1),
        offset=min(words.unsigned(), LAST_OFFSET),
        format=words.format(),
        scale=words.decimal(),
        unwrap=words.decimal(),
    )


def _set_point(session: FirmwareRun, words: CommandWords) -> None:
    """Set a constant setpoint, or a pulse or a ramp; a fourth number is read and means nothing."""
    name = words.choice(SHAPE_NAMES)
    if name is None:
        _hold(session, words.decimal())
        return
    start, end, length, _ = (words.decimal() for _ in range(4))
    session.port.wave.begin(SHAPES[name], start, end, length)
    session.port.coasting = False


def _set_zero(session: FirmwareRun, words: CommandWords) -> None:
    """Set the setpoint to 0, in any control mode."""
    _hold(session, 0.0)


def _set_one(session: FirmwareRun, words: CommandWords) -> None:
    """Set the setpoint to 1, in any control mode."""
    _hold(session, 1.0)


def _hold(session: FirmwareRun, value: float) -> None:
    session.port.wave.hold(value)
    session.port.coasting = False


def _limit_all(session: FirmwareRun, words: CommandWords) -> None:
    """Set the largest drive of all ports, 0..1."""
    most = fixed_point(words.decimal())
    for port in session.ports:
        port.bridge.limit = most


def _limit(session: FirmwareRun, words: CommandWords) -> None:
    """Set the largest drive of this port, 0..1."""
    session.port.bridge.limit = fixed_point(words.decimal())


def _pwm_parameters(session: FirmwareRun, words: CommandWords) -> None:
    """Set the drive below which slots are used, and the one below which it is 0; both 0..1."""
    threshold, least = words.decimal(), words.decimal()
    session.port.bridge.threshold = fixed_point(threshold)
    session.port.bridge.least = fixed_point(least)


def _select(session: FirmwareRun, words: CommandWords) -> None:
    """Report a mode every 100 ms; without a mode, end the reports."""
    mode = words.integer_or_none()
    if mode is None:
        session.port.selection.clear()
    else:
        session.port.select(_within(mode, MODES - 1), DEFAULT_PERIOD)


def _select_rate(session: FirmwareRun, words: CommandWords) -> None:
    """Set the time between two reports [ms]; 0: one report for each message."""
    session.port.selection.period = _within(words.integer(), LONGEST_PERIOD)


def _combine(session: FirmwareRun, words: CommandWords) -> None:
    """Set the modes of a slot, and forget the selected mode."""
    port = session.port
    slot = _within(words.integer(), LAST_SLOT)
    port.combinations.pop(slot, None)
    pairs: list[tuple[int, int]] = []
    while len(pairs) < MOST_PAIRS and (mode := words.integer_or_none()) is not None:
        pairs.append((_within(mode, MODES - 1), _within(words.integer(), 15)))
        port.combinations[slot] = tuple(pairs)
    port.selection.forget_mode()
    port.combine(slot, pairs)


def _within(value: int, highest: int) -> int:
    return max(0, min(highest, value))


COMMANDS: dict[str, Command] = {
    "help": _help,
    "?": _help,
    "clear_faults": _clear_faults,
    "port": _port,
    "list": _list,
    "ledmode": _light_mode,
    "pwm": _pwm,
    "coast": _coast,
    "pid": _pid,
    "pid_diff": _pid_diff,
    "set": _set_point,
    "off": _set_zero,
    "on": _set_one,
    "vin": _supply,
    "pwmparams": _pwm_parameters,
    "plimit": _limit_all,
    "port_plimit": _limit,
    "select": _select,
    "selrate": _select_rate,
    "combi": _combine,
    "echo": _echo,
    "debug": _debug,
    "version": _version,
    "signature": _signature,
}
"""Commands in the order of the search for a shortened word: ``c`` is clear_faults, ``s`` is set."""

NAMES = tuple(COMMANDS)
