"""``brickpose``: the program's command line."""

from __future__ import annotations

import argparse
import logging
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

from app.console import say
from app.course.options import add_check, add_learn
from app.interruption import Interrupted, deferred
from app.lab.calibrate.options import add_calibrate
from app.lab.evaluate_options import add_evaluate
from app.lab.localize.options import add_localize
from app.lab.mapping.options import add_map_command
from app.lab.sweep.options import add_sweep
from app.lab.trajectories.trajectory import TrajectoryError
from app.options import (
    CommandParser,
    Commands,
    add_address,
    add_camera,
    add_condition,
    add_config,
    add_map,
    add_own_models,
    add_profile,
    add_serial_port,
    config_from,
)
from app.page.access_options import add_access
from app.recordings.options import add_record
from app.ros2.export.options import add_export
from app.settings.conditions import check_supported
from app.settings.config import ROBOTS, ROOT, Config
from app.tools.options import add_doctor, add_emulate_hat, add_replay
from robot.errors import BrickPoseError
from robot.fields.field import FieldError
from robot.settings import SettingError

if TYPE_CHECKING:
    from fastapi import APIRouter

LOOK_S = 0.2
"""Interval of checking whether a signal asks to end [s]."""

PATIENCE_S = 10.0
"""Time that a benchmark has to end [s]."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; return 0 on success, 2 on a wrong argument, 1 on any other failure.

    After Ctrl-C it is 130, after SIGTERM 143; but 0 where a signal is the usual end: of servers.
    """
    logging.basicConfig(level=logging.WARNING, format="%(levelname)s %(name)s: %(message)s")
    parsed = _parser().parse_args(arguments)
    try:
        return int(parsed.command(parsed))
    except (SettingError, FieldError, TrajectoryError) as error:
        return _complain(error, 2)
    except (BrickPoseError, OSError) as error:
        return _complain(error, 1)
    except Interrupted as interrupted:
        return interrupted.code


def _parser() -> argparse.ArgumentParser:
    parser = CommandParser(
        prog="brickpose",
        description="A LEGO robot that localizes itself on taped floors.",
    )
    parser.add_argument("--version", action="version", version=f"brickpose {version('brickpose')}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    _add_run(commands)
    add_record(commands)
    add_replay(commands)
    add_evaluate(commands)
    add_sweep(commands)
    add_localize(commands)
    add_calibrate(commands)
    add_map_command(commands)
    add_emulate_hat(commands)
    add_doctor(commands)
    add_export(commands)
    learn = add_learn(commands)
    _add_serving(learn)
    learn.set_defaults(command=_learn)
    add_check(commands)
    _add_bench(commands)
    return parser


def _add_run(commands: Commands) -> None:
    run = commands.add_parser(
        "run",
        help="serve the dashboard with one robot",
        description="Serve the dashboard with one robot. Ctrl-C stops the motors and ends.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    _add_serving(run)
    run.set_defaults(command=_run)


def _add_serving(run: argparse.ArgumentParser) -> None:
    default = Config()
    run.add_argument(
        "--robot",
        choices=ROBOTS,
        help="sim: physics (pybullet); kinematic: perfect wheels, without pybullet; "
        "buildhat: the real one (default: sim where pybullet is installed)",
    )
    add_serial_port(run)
    add_camera(run)
    add_map(run)
    add_address(run)
    run.add_argument(
        "--seed",
        type=int,
        help=f"seed of everything random (default: {default.seed})",
    )
    add_access(run)
    add_condition(run)
    add_profile(run)
    add_config(run)
    add_own_models(run)
    _add_start_pose(run)
    _add_outlets(run)


def _add_start_pose(run: argparse.ArgumentParser) -> None:
    run.add_argument(
        "--restore-pose",
        action="store_true",
        help="start where the last run on the same map ended",
    )
    run.add_argument(
        "--pose-file",
        metavar="FILE",
        help="where the pose is saved (default: a file a robot and map in the user's state folder)",
    )


def _add_outlets(run: argparse.ArgumentParser) -> None:
    run.add_argument(
        "--record",
        metavar="DIR",
        help="record everything to a new folder in this one (docs/recordings.md)",
    )
    run.add_argument(
        "--ros2",
        action="store_true",
        help="be a robot of ROS 2, over DDS (docs/ros2.md)",
    )
    run.add_argument(
        "--foxglove",
        action="store_true",
        help="serve Foxglove, at /foxglove on the same port (docs/ros2.md)",
    )


def _add_bench(commands: Commands) -> None:
    bench = commands.add_parser(
        "bench", help="measure, side by side with peers", argument_default=None
    )
    bench.add_argument(
        "names", nargs="*", metavar="NAME", help="which (default: all that are quick)"
    )
    bench.add_argument("--json", type=Path, metavar="FILE", help="write the figures here too")
    bench.add_argument(
        "--minutes",
        type=float,
        metavar="N",
        help="how long the soak test runs, a minute at least (default: 10)",
    )
    bench.set_defaults(command=_bench)


def _run(parsed: argparse.Namespace) -> int:
    return _serve(parsed, config_from(parsed))


def _learn(parsed: argparse.Namespace) -> int:
    from app.course.learn_command import prepare  # noqa: PLC0415

    config, router, path = prepare(parsed, config_from(parsed))
    return _serve(parsed, config, (router,), path)


def _serve(
    parsed: argparse.Namespace, wanted: Config, routers: Sequence[APIRouter] = (), path: str = "/"
) -> int:
    # Imported here, so that a wrong argument is refused at once.
    from app.engine.build import build_program  # noqa: PLC0415
    from app.engine.robots import resolve_robot  # noqa: PLC0415
    from app.page.access_options import announce, certificate_of, tokens_of  # noqa: PLC0415
    from app.page.listening import listen  # noqa: PLC0415
    from app.page.serving import serve, serve_on  # noqa: PLC0415
    from sim.real_time import RealTime  # noqa: PLC0415

    config, missing = resolve_robot(wanted)
    _refuse_without_effect(parsed, config)
    certificate = certificate_of(vars(parsed))
    with listen(config.host, config.port) as listening:
        port = listening.getsockname()[1]
        tokens = tokens_of(vars(parsed), listening, inviting=config.ros2.foxglove)
        if missing:
            say(f"The kinematic robot drives, with perfect wheels: {missing}")
        program = build_program(config, RealTime())
        scheme = "http" if certificate is None else "https"
        ready = partial(
            announce, listening, tokens, scheme, foxglove=config.ros2.foxglove, path=path
        )
        following = serve(program, listening, tokens, certificate, ready, routers)
    if following is not None:
        serve_on(following, port, tokens, certificate, routers)
    return 0


def _refuse_without_effect(parsed: argparse.Namespace, config: Config) -> None:
    for name, option in (("serial_port", "--serial-port"), ("camera", "--camera")):
        if name in vars(parsed) and config.robot != "buildhat":
            raise SettingError(
                f"{option} has no effect with --robot {config.robot}; valid is buildhat"
            )
    if "condition" in parsed and config.robot == "buildhat":
        raise SettingError(
            "--condition has no effect with --robot buildhat; valid are sim, kinematic"
        )
    if "condition" in parsed:
        check_supported(config.robot, parsed.condition)


def _bench(parsed: argparse.Namespace) -> int:
    # Benchmarks exist only in a checkout: the program does not import them.
    if not (ROOT / "benchmarks").is_dir():
        raise SettingError("benchmarks are only in a checkout of the sources, not in the wheel")
    written = [] if parsed.json is None else ["--json", str(parsed.json.absolute())]
    minutes = [] if parsed.minutes is None else ["--minutes", str(parsed.minutes)]
    command = [sys.executable, "-m", "benchmarks", *parsed.names, *written, *minutes]
    # In a session of its own, so that Ctrl-C reaches it by this program alone.
    with deferred() as asked:
        child = subprocess.Popen(command, cwd=ROOT, start_new_session=True)
        try:
            while child.poll() is None and not asked():
                with suppress(subprocess.TimeoutExpired):
                    child.wait(LOOK_S)
        finally:
            _end(child)
    return child.returncode


def _end(child: subprocess.Popen[bytes]) -> None:
    """End a process that may have ended already, within a bounded time."""
    child.terminate()
    try:
        child.wait(PATIENCE_S)
    except subprocess.TimeoutExpired:
        child.kill()
        child.wait()


def _complain(error: Exception, code: int) -> int:
    text = str(error) or type(error).__name__
    sys.stderr.write(f"brickpose: {text}\n")
    return code
