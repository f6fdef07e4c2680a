"""Commands that choose which data a device sends and which of them are reported."""

from __future__ import annotations

from robot.errors import CommandError
from sim.hat.firmware.reports import DEFAULT_PERIOD, ONCE, WHOLE_MODE
from sim.hat.firmware.variables import MODES, PAYLOAD
from sim.hat.language.session import Session
from sim.hat.language.words import Words

LAST_OFFSET = 127
LAST_SLOT = 7
MOST_PAIRS = 15
LONGEST_PERIOD = 1_000_000_000


def select(session: Session, words: Words) -> None:
    """Report a mode, or one number in it, every 100 ms; without a mode, end the reports."""
    _select(session, words, DEFAULT_PERIOD)


def select_once(session: Session, words: Words) -> None:
    """Report the next message only."""
    _select(session, words, ONCE)


def _select(session: Session, words: Words, period: int) -> None:
    mode = words.integer_or_none()
    if mode is None:
        session.port.selection.clear()
        return
    offset, layout = words.integer_or_none(), ""
    if offset is None:
        offset = WHOLE_MODE
    else:
        offset, layout = _within(offset, LAST_OFFSET), _format(session, words)
    session.port.select(_within(mode, MODES - 1), offset, layout, period)


def _format(session: Session, words: Words) -> str:
    """Read a format; a mistake also ends the reports."""
    try:
        return words.format()
    except CommandError:
        session.port.selection.clear()
        raise


def select_rate(session: Session, words: Words) -> None:
    """Set the time between two reports [ms]; 0: one report for each message."""
    session.port.selection.period = _within(words.integer(), LONGEST_PERIOD)


def combine(session: Session, words: Words) -> None:
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


def write_one_header(session: Session, words: Words) -> None:
    """Send a message to the device unchanged: type and payload."""
    kind = words.hexadecimal()
    session.port.send(kind & 0xFF, _payload(words))


def write_two_headers(session: Session, words: Words) -> None:
    """Read a message with two header bytes and do nothing: the emulated motors ignore it."""
    words.hexadecimal()
    words.hexadecimal()
    _payload(words)


def _payload(words: Words) -> bytes:
    payload = bytearray()
    while len(payload) < PAYLOAD:
        try:
            payload.append(words.hexadecimal() & 0xFF)
        except CommandError:
            break
    return bytes(payload)


def _within(value: int, highest: int) -> int:
    return max(0, min(highest, value))
