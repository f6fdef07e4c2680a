"""The command line of ``brickpose evaluate``; what takes long to load is loaded when it is used."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

OUT = Path("evaluation")
Commands = Any
"""What ``add_subparsers`` returns."""


def add_evaluate(commands: Commands) -> None:
    """Add the command and its own sub-command."""
    command = commands.add_parser(
        "evaluate",
        help="the paper's experiment: how far off are odometry and localization?",
        description="Drive the open-loop figure-eight with simulated robots, follow each with the "
        "pose known and with it told wrong, and write a report. Or, with --recording and --truth, "
        "compare a recorded trajectory with the true one. Metres, radians, seconds.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
        allow_abbrev=False,
    )
    add_what(command)
    add_out(command, OUT)
    add_workers(command)
    command.add_argument("--seeds", type=int, default=12, help="how many robots")
    command.add_argument("--laps", type=int, default=2, help="laps of the figure-eight")
    command.add_argument(
        "--offset",
        type=float,
        nargs=3,
        metavar=("DX", "DY", "DTHETA"),
        default=[-0.1, -0.1, 0.3],
        help="how far the told pose is off [m, m, rad]",
    )
    add_worlds(command)
    add_recording(command)
    command.set_defaults(command=_evaluate)
    _add_models(command.add_subparsers(metavar="[models]"))


def add_what(command: argparse.ArgumentParser) -> None:
    """Which map, robots and settings."""
    command.add_argument(
        "--map",
        metavar="NAME|FILE",
        default=argparse.SUPPRESS,
        help="a field of maps/, or an .svg or .yaml file (default: square)",
    )
    command.add_argument("--first-seed", type=int, default=0, help="seed of the first robot")
    command.add_argument(
        "--config",
        type=Path,
        metavar="FILE.toml",
        default=argparse.SUPPRESS,
        help="settings, as for run",
    )


def add_out(command: argparse.ArgumentParser, folder: Path) -> None:
    """Where results go."""
    command.add_argument(
        "--out", type=Path, metavar="DIR", default=folder, help="where the results go"
    )


def add_workers(command: argparse.ArgumentParser) -> None:
    """Who does the work."""
    command.add_argument(
        "--workers",
        type=int,
        metavar="N",
        default=argparse.SUPPRESS,
        help="processes of this machine (default: one a core)",
    )
    command.add_argument(
        "--cluster",
        metavar="ADDRESS",
        default=argparse.SUPPRESS,
        help="a Dask scheduler instead, as tcp://host:8786",
    )


def add_worlds(command: argparse.ArgumentParser) -> None:
    """In which worlds."""
    command.add_argument(
        "--world",
        action="append",
        choices=("sim", "as-real", "kinematic"),
        default=argparse.SUPPRESS,
        help="may be given more than once (default: sim and as-real; kinematic without pybullet)",
    )


def add_recording(command: argparse.ArgumentParser) -> None:
    """A recording instead of a simulation."""
    recording = command.add_argument_group("a recording instead of a simulation")
    recording.add_argument(
        "--recording",
        type=Path,
        metavar="FILE",
        default=argparse.SUPPRESS,
        help="what was estimated: TUM text, Motive CSV or MRCLAM",
    )
    recording.add_argument(
        "--truth",
        type=Path,
        metavar="FILE",
        default=argparse.SUPPRESS,
        help="what was true: TUM text, Motive CSV or MRCLAM",
    )
    recording.add_argument(
        "--body",
        metavar="NAME",
        default=argparse.SUPPRESS,
        help="which rigid body of a Motive file, if it has several",
    )
    recording.add_argument(
        "--clock-offset",
        metavar="SECONDS",
        default="auto",
        help="what to add to the recording's stamps; auto estimates it",
    )


def _add_models(what: Any) -> None:
    models = what.add_parser(
        "models",
        help="statistics of the motion and sensor models, and fitted parameters",
        description="Repeat motions and scans of one simulated robot, or take a recording, compare "
        "them with the models, and write fitted parameters for --config.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
        allow_abbrev=False,
    )
    add_what(models)
    add_out(models, OUT / "models")
    add_workers(models)
    models.add_argument("--repeats", type=int, default=20, help="how often each motion is driven")
    models.add_argument(
        "--seeds", type=int, default=6, help="runs in which fitted and default settings compare"
    )
    add_worlds(models)
    add_recording(models)
    models.set_defaults(command=_models)


def _evaluate(parsed: argparse.Namespace) -> int:
    from app.evaluation.command import evaluate_command  # noqa: PLC0415

    return evaluate_command(parsed)


def _models(parsed: argparse.Namespace) -> int:
    from app.model_fits.command import models_command  # noqa: PLC0415

    return models_command(parsed)
