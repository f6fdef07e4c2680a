"""``brickpose emulate-hat``: connects board, surroundings, sockets and the clock."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Mapping
from contextlib import ExitStack, suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from app.console import say
from app.engine.build import Streams
from app.interruption import Interrupted, deferred
from app.options import config_file
from app.settings.config import MAPS, Config
from robot.description.spec import RobotSpec
from robot.description.wiring import PORTS
from robot.errors import PackageError
from robot.fields.field_loading import load_field
from robot.geometry import Twist2
from robot.settings import SettingError
from sim.engines import choose_engine, physics_world
from sim.floor_camera import FloorCamera
from sim.hat.motor_figures import DeviceError, MotorFigures, figures_described, figures_named
from sim.hat_emulator.control import Control
from sim.hat_emulator.emulator import Emulator, InitialState
from sim.hat_emulator.line_server import LineServer, TypedLines
from sim.hat_emulator.picture_server import PictureServer
from sim.hat_emulator.pseudo_terminal import PseudoTerminal
from sim.hat_emulator.surroundings import RobotOnField, Surroundings, Table
from sim.imperfections import draw

SWITCH_INTERVAL = 0.0005
"""How long one thread may delay the others [s]: the board's ticks are 1 ms."""

STANDARD_INPUT = 0


def emulate_hat(options: Mapping[str, Any]) -> int:
    """Emulate the board until Ctrl-C or SIGTERM; return 0.

    Raises:
        SettingError: an option is not valid or has no effect.
        FieldError: the map cannot be used.
        OSError: the serial port or a socket cannot be created.
        PackageError: ``--world sim`` was asked for, but no physics engine is installed.
    """
    config = _config(options)
    spec = RobotSpec.load()
    world = _world(options, config)
    motors = _motors(options.get("motors"), spec)
    sys.setswitchinterval(SWITCH_INTERVAL)
    # Without this, a program in the background of a shell stops when it reads from the terminal.
    signal.signal(signal.SIGTTIN, signal.SIG_IGN)
    scene = _scene(options, config, spec, world, motors)
    with suppress(Interrupted), deferred() as asked, ExitStack() as stack:
        _run(stack, options, config, scene, motors, asked)
    return 0


@dataclass(frozen=True)
class _Scene:
    """What is around the board."""

    surroundings: Surroundings
    true: RobotSpec
    """The true robot."""
    camera: FloorCamera | None = None
    """The robot's camera, if its pictures are asked for."""


def _scene(
    options: Mapping[str, Any],
    config: Config,
    spec: RobotSpec,
    world: str,
    motors: Mapping[int, MotorFigures],
) -> _Scene:
    """Make the world, which takes long, and leaves nothing behind if a signal ends the program."""
    if world != "sim":
        return _Scene(Table(motors), spec)
    field = load_field(config.map, MAPS)
    true, rng = _true_robot(config, spec)
    world_with_forces = physics_world(config.sim.engine, true, field.start, config.sim.physics)
    around = RobotOnField(world_with_forces, true, motors)
    if "pictures" not in options:
        return _Scene(around, true)
    camera = FloorCamera(true.floor_view, field.floor, config.sim.camera, rng)
    # The first picture takes long, since it loads compiled code; later it would stall the board.
    camera.picture(around.truth, Twist2(0.0, 0.0))
    return _Scene(around, true, camera)


def _run(
    stack: ExitStack,
    options: Mapping[str, Any],
    config: Config,
    scene: _Scene,
    motors: Mapping[int, MotorFigures],
    until: Callable[[], bool],
) -> None:
    stack.callback(scene.surroundings.close)
    terminal = PseudoTerminal(options.get("link"))
    stack.callback(terminal.close)
    beginning = InitialState(warm="bootloader" not in options, seed=config.seed)
    if "firmware" in options:
        beginning = replace(beginning, version=options["firmware"])
    emulator = Emulator(scene.surroundings, motors, terminal, beginning)
    stack.callback(emulator.loop.close)
    if scene.camera is not None and isinstance(scene.surroundings, RobotOnField):
        server = PictureServer(options["pictures"], scene.camera)
        stack.callback(server.close)
        scene.surroundings.has_camera(
            config.sim.camera, scene.true.lens.readout, emulator.wall, server.take
        )
        server.start()
    control = Control(emulator)
    if "control" in options:
        stack.callback(LineServer(options["control"], control.answer, emulator.loop).close)
    TypedLines(STANDARD_INPUT, control.answer, emulator.loop, say)
    say(f"Build HAT at {terminal.name}")
    emulator.loop.run(until)


def _true_robot(config: Config, spec: RobotSpec) -> tuple[RobotSpec, np.random.Generator]:
    """Return the true robot, the same as in ``run --robot sim``, and its random generator."""
    rng = Streams.of(config.seed).robot
    return draw(spec, config.sim.imperfections, rng), rng


def _config(options: Mapping[str, Any]) -> Config:
    config = config_file(options)
    return replace(config, **{name: options[name] for name in ("map", "seed") if name in options})


def _world(options: Mapping[str, Any], config: Config) -> str:
    """Return the name of the world; refuse options that do not go with it."""
    world = options.get("world") or _usual_world(config)
    if world == "sim":
        choose_engine(config.sim.engine)
    if world == "free":
        for name in ("pictures", "map"):
            if name in options:
                raise SettingError(f"--{name} has no effect with --world free; valid is sim")
    if "firmware" in options and "bootloader" in options:
        raise SettingError("--firmware runs or --bootloader waits; give one of them")
    return str(world)


def _usual_world(config: Config) -> str:
    try:
        choose_engine(config.sim.engine)
    except PackageError:
        return "free"
    return "sim"


def _motors(text: str | None, spec: RobotSpec) -> dict[int, MotorFigures]:
    """Return the motors' figures by port, from a text such as A=large,B=large."""
    if text is None:
        return {PORTS.index(joint.port): figures_described(joint.motor) for joint in spec.joints}
    motors = {}
    for part in text.split(",") if text else ():
        port, _, name = part.strip().partition("=")
        if port not in PORTS:
            raise SettingError(f"--motors: no port {port!r}; valid are {', '.join(PORTS)}")
        try:
            motors[PORTS.index(port)] = figures_named(name)
        except DeviceError as error:
            raise SettingError(f"--motors: {error}") from error
    return motors
