"""Commands that drive a port: control mode, setpoint, limits."""

from __future__ import annotations

from robot.errors import CommandError
from sim.hat.devices.device import PORTS
from sim.hat.firmware.bridge import fixed_point
from sim.hat.firmware.controllers import Control
from sim.hat.firmware.variables import MODES, Variable
from sim.hat.firmware.waveforms import Shape
from sim.hat.language.session import Session
from sim.hat.language.words import Words

LAST_OFFSET = 127
SHAPES = {shape.value: shape for shape in Shape}
SHAPE_NAMES = tuple(SHAPES)


def pwm(session: Session, words: Words) -> None:
    """Drive the motor directly by the setpoint, which stays as it is."""
    session.port.controller.control = Control.DIRECT
    session.port.coasting = False


def coast(session: Session, words: Words) -> None:
    """Let the motor coast; the setpoint continues, but has no effect."""
    session.port.coasting = True


def pid(session: Session, words: Words) -> None:
    """Control a variable."""
    _control(session, words, Control.VALUE)


def pid_diff(session: Session, words: Words) -> None:
    """Control a variable's rate of change."""
    _control(session, words, Control.RATE)


def _control(session: Session, words: Words, control: Control) -> None:
    """Read a controller's parameters.

    After a mistake, the parameters before it are kept, and the old setpoint drives the motor.
    """
    controller = session.port.controller
    session.port.coasting = False
    controller.control = Control.DIRECT
    controller.variable = _variable(words)
    controller.proportional_gain = words.decimal()
    controller.integral_gain = words.decimal()
    controller.derivative_gain = words.decimal()
    controller.windup = words.decimal()
    controller.dead_zone = words.decimal()
    controller.control = control


def _variable(words: Words) -> Variable:
    return Variable(
        port=min(words.unsigned(), PORTS - 1),
        mode=min(words.unsigned(), MODES - 1),
        offset=min(words.unsigned(), LAST_OFFSET),
        format=words.format(),
        scale=words.decimal(),
        unwrap=words.decimal(),
    )


def set_point(session: Session, words: Words) -> None:
    """Set a constant setpoint, or one that follows a shape."""
    name = words.choice(SHAPE_NAMES)
    if name is None:
        _hold(session, words.decimal())
        return
    shape = SHAPES[name]
    low, high, period, phase = (words.decimal() for _ in range(4))
    session.port.wave.begin(shape, low, high, period, phase)
    session.port.coasting = False
    if shape is Shape.FOLLOWING:
        _follow(session, words)


def _follow(session: Session, words: Words) -> None:
    """Read the variable to follow; after a mistake, the setpoint follows nothing."""
    try:
        session.port.wave.follow(_variable(words))
    except CommandError:
        session.port.wave.follow(Variable())
        raise


def off(session: Session, words: Words) -> None:
    """Set the setpoint to 0, in any control mode."""
    _hold(session, 0.0)


def on(session: Session, words: Words) -> None:
    """Set the setpoint to 1, in any control mode."""
    _hold(session, 1.0)


def _hold(session: Session, value: float) -> None:
    session.port.wave.hold(value)
    session.port.coasting = False


def limit_all(session: Session, words: Words) -> None:
    """Set the largest drive of all ports, 0..1."""
    most = fixed_point(words.decimal())
    for port in session.ports:
        port.bridge.limit = most


def limit(session: Session, words: Words) -> None:
    """Set the largest drive of this port, 0..1."""
    session.port.bridge.limit = fixed_point(words.decimal())


def pwm_parameters(session: Session, words: Words) -> None:
    """Set the drive below which slots are used, and the one below which it is 0; both 0..1."""
    threshold, least = words.decimal(), words.decimal()
    session.port.bridge.threshold = fixed_point(threshold)
    session.port.bridge.least = fixed_point(least)
