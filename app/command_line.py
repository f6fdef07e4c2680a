"""``brickpose``: the program's command line."""

from __future__ import annotations

import argparse
import logging
import signal
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from app.conditions import in_condition, require_effect
from app.config import ROBOTS, Config, load_config
from app.console import say
from app.doctor.options import add_doctor
from app.evaluation.options import add_evaluate
from app.hat_emulator.options import add_emulate_hat
from app.localize.options import add_localize
from app.options import add_camera, add_condition, add_config, add_map, add_serial_port
from app.recording.options import add_record
from app.replay.options import add_replay
from app.ros2.export.options import add_export
from app.sweep.options import add_sweep
from app.trajectories.trajectory import TrajectoryError
from robot.fields.field import FieldError
from robot.settings import SettingError

OPTIONS = (
    "robot", "map", "host", "port", "seed", "sensor_model", "motion_model", "models",
    "camera_source",
)  # fmt: skip
"""Options that are settings of the same name."""

START_OPTIONS = ("restore_pose", "pose_file")
"""Options that are settings of the start pose."""

ROUTE_OPTIONS = {"ros2": "dds", "foxglove": "foxglove"}
"""Options that are settings of the topics, under this name."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; returns 0 when it did its job, 2 on a wrong argument, 1 on another failure."""
    logging.basicConfig(level=logging.WARNING, format="%(levelname)s %(name)s: %(message)s")
    parsed = _parser().parse_args(arguments)
    # A program that is told to end cleans up as by Ctrl-C; a server has its own way later.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        return int(parsed.command(parsed))
    except (SettingError, FieldError, TrajectoryError) as error:
        return _complain(error, 2)
    except (OSError, ValueError, ImportError, RuntimeError) as error:
        return _complain(error, 1)
    except KeyboardInterrupt:
        return 0 if parsed.command is _run else _complain(RuntimeError("interrupted"), 1)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="brickpose",
        description="A LEGO robot that localizes itself on taped floors.",
        allow_abbrev=False,
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    _add_run(commands)
    add_record(commands)
    add_replay(commands)
    add_evaluate(commands)
    add_sweep(commands)
    add_localize(commands)
    add_emulate_hat(commands)
    add_doctor(commands)
    add_export(commands)
    _add_bench(commands)
    return parser


def _add_run(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    default = Config()
    run = commands.add_parser(
        "run",
        help="serve the dashboard with one robot",
        description="Serve the dashboard with one robot. Ctrl-C stops the motors and ends.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
        allow_abbrev=False,
    )
    run.add_argument(
        "--robot",
        choices=ROBOTS,
        help="sim: physics (pybullet); kinematic: perfect wheels, without pybullet; "
        "buildhat: the real one (default: sim where pybullet is installed)",
        default=argparse.SUPPRESS,
    )
    add_serial_port(run)
    add_camera(run)
    add_map(run)
    run.add_argument(
        "--host",
        default=argparse.SUPPRESS,
        help=f"address to listen on; 0.0.0.0 is all (default: {default.host})",
    )
    run.add_argument(
        "--port",
        type=int,
        default=argparse.SUPPRESS,
        help=f"port to listen on; 0 is any free one (default: {default.port})",
    )
    run.add_argument(
        "--seed",
        type=int,
        default=argparse.SUPPRESS,
        help=f"seed of everything random (default: {default.seed})",
    )
    add_condition(run)
    add_config(run)
    _add_models(run)
    _add_start_pose(run)
    _add_outlets(run)
    run.set_defaults(command=_run)


def _add_start_pose(run: argparse.ArgumentParser) -> None:
    run.add_argument(
        "--restore-pose",
        action="store_true",
        default=argparse.SUPPRESS,
        help="start where the last run on the same map ended",
    )
    run.add_argument(
        "--pose-file",
        metavar="FILE",
        default=argparse.SUPPRESS,
        help="where the pose is saved (default: a file a robot and map in the user's state folder)",
    )


def _add_outlets(run: argparse.ArgumentParser) -> None:
    run.add_argument(
        "--record",
        metavar="DIR",
        default=argparse.SUPPRESS,
        help="record everything to a new folder in this one (docs/recordings.md)",
    )
    run.add_argument(
        "--ros2",
        action="store_true",
        default=argparse.SUPPRESS,
        help="be a robot of ROS 2, over DDS (docs/ros2.md)",
    )
    run.add_argument(
        "--foxglove",
        action="store_true",
        default=argparse.SUPPRESS,
        help=f"serve Foxglove, on port {Config().ros2.foxglove_port} (docs/ros2.md)",
    )


def _add_models(run: argparse.ArgumentParser) -> None:
    for kind in ("sensor", "motion"):
        run.add_argument(
            f"--{kind}-model",
            metavar="FILE.py:CLASS",
            default=argparse.SUPPRESS,
            help=f"a {kind} model of your own, taken anew when it is saved (docs/own_models.md)",
        )
    run.add_argument(
        "--models",
        metavar="DIR",
        default=argparse.SUPPRESS,
        help="a folder of models of your own, which the page offers",
    )


def _add_bench(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    bench = commands.add_parser(
        "bench", help="measure, side by side with peers", allow_abbrev=False
    )
    bench.add_argument(
        "names", nargs="*", metavar="NAME", help="which (default: all that take no minutes)"
    )
    bench.add_argument("--json", type=Path, metavar="FILE", help="write the figures here too")
    bench.set_defaults(command=_bench)


def _run(parsed: argparse.Namespace) -> int:
    wanted = config_from(parsed)
    # Imported here, so that a wrong argument is answered at once.
    from app.assembly import assemble, settle_robot  # noqa: PLC0415
    from app.web.address import address_of  # noqa: PLC0415
    from app.web.serving import listen, serve  # noqa: PLC0415
    from sim.real_time import RealTime  # noqa: PLC0415

    config, missing = settle_robot(wanted)
    _refuse_without_effect(parsed, config)
    with listen(config.host, config.port) as listening:
        if missing:
            say(f"The kinematic robot drives, with perfect wheels: {missing}")
        program = assemble(config, RealTime())
        say(f"BrickPose is at {address_of(listening)} (Ctrl-C ends it)")
        serve(program, listening)
    return 0


def _refuse_without_effect(parsed: argparse.Namespace, config: Config) -> None:
    for name, option in (("serial_port", "--serial-port"), ("camera_source", "--camera")):
        if name in vars(parsed) and config.robot != "buildhat":
            raise SettingError(
                f"{option} has no effect with --robot {config.robot}; valid is buildhat"
            )
    if "condition" in parsed and config.robot == "buildhat":
        raise SettingError(
            "--condition has no effect with --robot buildhat; valid are sim, kinematic"
        )
    if "condition" in parsed:
        require_effect(config.robot, parsed.condition)


def _bench(parsed: argparse.Namespace) -> int:
    from benchmarks.run import run  # noqa: PLC0415

    return run(parsed.names, parsed.json)


def config_from(parsed: argparse.Namespace) -> Config:
    """The configuration file, if there is one, with the command line's options over it."""
    given = vars(parsed)
    config = load_config(given["config"]) if "config" in given else Config()
    over = {name: given[name] for name in OPTIONS if name in given}
    over_start = {name: given[name] for name in START_OPTIONS if name in given}
    config = replace(config, start_pose=replace(config.start_pose, **over_start))
    if "serial_port" in given:
        over["build_hat"] = replace(config.build_hat, serial_port=given["serial_port"])
    config = replace(config, **over)
    if "record" in given:
        recording = replace(config.recording, record=True, folder=given["record"])
        config = replace(config, recording=recording)
    routes = {name: given[option] for option, name in ROUTE_OPTIONS.items() if option in given}
    config = replace(config, ros2=replace(config.ros2, **routes))
    return in_condition(config, given["condition"]) if "condition" in given else config


def _complain(error: Exception, code: int) -> int:
    text = str(error) or type(error).__name__
    sys.stderr.write(f"brickpose: {text}\n")
    return code
