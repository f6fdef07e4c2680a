"""Table of all commands, the commands about the board itself, and the execution of a line."""

from __future__ import annotations

from collections.abc import Callable

from robot.errors import CommandError
from sim.hat.devices.device import PORTS
from sim.hat.firmware.power import supply_text
from sim.hat.language import data_commands, drive_commands
from sim.hat.language.help_text import HELP
from sim.hat.language.session import Session
from sim.hat.language.words import Words

LIGHT_MODES = (-1, 3)

Command = Callable[[Session, Words], None]


def execute(session: Session, words: Words) -> None:
    """Execute the commands of a line; the first mistake ends it, but earlier effects stay."""
    try:
        while words.next_command():
            _command(words)(session, words)
    except CommandError:
        session.write("Error\r\n")


def _command(words: Words) -> Command:
    name = words.choice(NAMES)
    if name is None:
        raise CommandError(f"valid are {', '.join(NAMES)}")
    return COMMANDS[name]


def _help(session: Session, words: Words) -> None:
    session.write(HELP)


def _clear_faults(session: Session, words: Words) -> None:
    """Do nothing: the chips forget past faults, and lasting faults are reported again anyway."""


def _port(session: Session, words: Words) -> None:
    session.current = min(words.unsigned(), PORTS - 1)


def _list(session: Session, words: Words) -> None:
    for port in session.ports:
        session.write(port.describe())


def _light_mode(session: Session, words: Words) -> None:
    low, high = LIGHT_MODES
    session.light_mode = max(low, min(high, words.integer()))


def _supply(session: Session, words: Words) -> None:
    session.write(supply_text(session.power.millivolts))


def _echo(session: Session, words: Words) -> None:
    session.echo = words.integer()


def _debug(session: Session, words: Words) -> None:
    session.debug = words.integer()


def _version(session: Session, words: Words) -> None:
    session.write(f"Firmware version: {session.version}\r\n")


def _signature(session: Session, words: Words) -> None:
    session.write(f"Firmware signature: {session.signature.hex(' ').upper()}\r\n")


COMMANDS: dict[str, Command] = {
    "help": _help,
    "?": _help,
    "clear_faults": _clear_faults,
    "port": _port,
    "list": _list,
    "ledmode": _light_mode,
    "pwm": drive_commands.pwm,
    "coast": drive_commands.coast,
    "pid": drive_commands.pid,
    "pid_diff": drive_commands.pid_diff,
    "set": drive_commands.set_point,
    "off": drive_commands.off,
    "on": drive_commands.on,
    "vin": _supply,
    "pwmparams": drive_commands.pwm_parameters,
    "plimit": drive_commands.limit_all,
    "port_plimit": drive_commands.limit,
    "select": data_commands.select,
    "selonce": data_commands.select_once,
    "selrate": data_commands.select_rate,
    "combi": data_commands.combine,
    "write1": data_commands.write_one_header,
    "write2": data_commands.write_two_headers,
    "echo": _echo,
    "debug": _debug,
    "version": _version,
    "signature": _signature,
}
"""Commands in the order of the search for a shortened word: ``c`` is clear_faults, ``s`` is set."""

NAMES = tuple(COMMANDS)
