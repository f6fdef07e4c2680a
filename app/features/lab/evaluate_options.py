"""The command line of ``brickpose evaluate``; slow imports are delayed until they are used."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from app.command_parser import NO_OPTIONS, CommandParser
from app.interruption import interruptible
from app.options import add_config, add_settings
from app.settings.conditions import condition_names
from robot.settings import SettingError

SIMULATED = ("map", "first_seed", "config", "workers", "cluster", "seeds", "world")
"""Options valid with a simulation; the experiment and the models have more."""
RECORDED = (
    "recording", "truth", "body", "clock_offset", "recording_topic", "truth_topic",
)  # fmt: skip
"""Options valid with a recording."""
VALID = {
    ("experiment", False): (*SIMULATED, "laps", "offset", "profile", "calibrate"),
    ("models", False): (*SIMULATED, "repeats"),
    ("experiment", True): (*RECORDED, "max_time_difference"),
    ("models", True): (*RECORDED, "config"),
}
"""Valid options by what is evaluated and whether it is recorded; ``out`` is always valid."""
INTEGRITY = (
    "map", "condition", "start", "first_seed", "seeds", "laps", "config", "workers", "cluster",
)  # fmt: skip
"""Options valid with integrity; ``out`` is valid, too."""
NAVIGATION = (
    "map", "condition", "trial", "first_seed", "seeds", "goals", "minutes", "calibrate", "config",
    "workers", "cluster",
)  # fmt: skip
"""Options valid with navigation; ``out`` is valid, too."""
MISHAPS = (
    "straight", "stuck", "pushed-along", "late-for-a-while", "late-by-turns", "enlarged", "shrunk",
    "hand-laid", "piece-elsewhere", "piece-missing", "own-shadow", "wheels-swapped",
    "wheel-reversed", "mirrored", "frozen", "lifted", "replugged", "light-wood", "dark-wood",
    "light-lino", "dark-lino", "light-carpet", "dark-carpet", "light-concrete", "dark-concrete",
)  # fmt: skip
"""Conditions of integrity that are more than settings, or of floors that nothing else needs."""
OWN_OPTIONS = {"integrity": INTEGRITY, "navigation": NAVIGATION}
"""Options of what has only its own."""
KINDS = {
    "experiment": "The paper's experiment: what is done if none of these is named.",
    "models": "Statistics of the models: of the motion and sensor models of one robot, or of "
    "recorded odometry with truth, and fitted parameters for --config.",
    "integrity": "Is it right when it says so: robots x fields x conditions x starts, what was "
    "claimed and what was true at each picture, Stanford diagrams and causes.",
    "navigation": "Does it get there: fields x conditions x trials x seeds, random goals, robots "
    "that are pushed or carried off, closed curves; where the true robot was.",
}
"""What can be evaluated, with its description."""


def add_evaluate(command: CommandParser) -> None:
    """Add the options of ``evaluate``."""
    command.description = (
        "Drive the open-loop figure-eight with simulated robots, follow each with the "
        "pose known and with a wrong one, and write a report. With --recording and --truth: "
        "compare a recorded trajectory with the true one. Metres, radians, seconds."
    )
    _add_common(command)
    command.set_defaults(command=_evaluate, what="experiment")
    kinds = command.add_subparsers(metavar="{experiment,models,integrity,navigation}")
    for name, about in KINDS.items():
        kind = kinds.add_parser(
            name,
            help=about.partition(":")[0],
            description=about,
        )
        {"integrity": _add_integrity, "navigation": _add_navigation}.get(name, _add_common)(kind)
        kind.set_defaults(what=name)


def _add_common(command: argparse.ArgumentParser) -> None:
    _add_out(command)
    _add_simulation(command)
    add_workers(command)
    _add_recording(command)


def _add_out(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="where the results go (default: evaluation; of models, integrity and navigation a "
        "folder in it)",
    )


def _add_robots(command: argparse.ArgumentParser, fields: str, more: str = "") -> None:
    """Add the options of robots x fields x conditions; ``fields`` are those of the default."""
    several: dict[str, Any] = {"nargs": "+", "action": "extend"}
    command.add_argument(
        "--map",
        metavar="NAME|FILE",
        **several,
        help=f"fields of maps/, generated-N (from a seed), or files (default: {fields})",
    )
    command.add_argument(
        "--condition", metavar="NAME", **several,
        help=f"which (default: default): {condition_names()}{more}",
    )  # fmt: skip
    command.add_argument(
        "--first-seed", type=int, metavar="N", help="seed of the first robot (default: 0)"
    )
    command.add_argument(
        "--seeds", type=int, metavar="N",
        help="how many robots on each field in each condition (default: 12)",
    )  # fmt: skip
    _add_out(command)
    add_config(command)
    add_workers(command)


def _add_integrity(command: argparse.ArgumentParser) -> None:
    """Add the options of integrity: robots x fields x conditions x starts."""
    _add_robots(command, "square stub town", f", {', '.join(MISHAPS)}")
    command.add_argument(
        "--start",
        metavar="START",
        nargs="+",
        action="extend",
        help="what is known of the pose (default: all): known, told-wrong, told-quarter, "
        "scattered, carried, known-carried, moved",
    )
    command.add_argument(
        "--laps", type=int, metavar="N",
        help="laps of the figure-eight (default: 1); carried drives take 17 s, moved ones 21 s",
    )  # fmt: skip


def _add_navigation(command: argparse.ArgumentParser) -> None:
    """Add the options of navigation: fields x conditions x trials."""
    _add_robots(command, "square tee town")
    command.add_argument(
        "--trial",
        metavar="TRIAL",
        nargs="+",
        action="extend",
        help="what is tried (default: goals): goals, pushed, carried, scattered, figure-eight, "
        "open-loop",
    )
    command.add_argument(
        "--goals", type=int, metavar="N",
        help="random goals of each robot (default: 20); a scattered one has one",
    )  # fmt: skip
    command.add_argument(
        "--minutes", type=float, metavar="N",
        help="how long a figure-eight is driven (default: 30)",
    )  # fmt: skip
    command.add_argument(
        "--calibrate",
        type=float,
        metavar="SECONDS",
        help="calibrate each robot first, by a drive of this duration",
    )


def add_workers(command: argparse.ArgumentParser) -> None:
    """Add the options that say which processes do the work."""
    command.add_argument(
        "--workers",
        type=int,
        metavar="N",
        help="processes of this machine (default: one a core)",
    )
    command.add_argument(
        "--cluster",
        metavar="ADDRESS",
        help="a Dask scheduler instead, as tcp://host:8786",
    )


def check_options(given: dict[str, Any]) -> None:
    """Refuse options that have no effect.

    Raises:
        SettingError: an option has no effect; names it and the valid ones.
    """
    if ("recording" in given) != ("truth" in given):
        raise SettingError("--recording and --truth are given together")
    recorded = "recording" in given
    valid = VALID[given["what"], recorded]
    for name in given:
        if name not in (*valid, "out", "what", *NO_OPTIONS):
            source = "a recording" if recorded else "a simulation"
            options = ", ".join(_option(item) for item in ("out", *valid))
            raise SettingError(
                f"{_option(name)} does not go with {given['what']} of {source}; valid are {options}"
            )


def _option(name: str) -> str:
    return "--" + name.replace("_", "-")


def _add_simulation(command: argparse.ArgumentParser) -> None:
    add_settings(command, "map")
    command.add_argument(
        "--first-seed", type=int, metavar="N", help="seed of the first robot (default: 0)"
    )
    command.add_argument(
        "--seeds",
        type=int,
        metavar="N",
        help="how many robots (default: 12); of models how many runs compare fitted and default "
        "settings (default: 6)",
    )
    command.add_argument(
        "--laps", type=int, metavar="N", help="laps of the figure-eight (default: 2)"
    )
    command.add_argument(
        "--offset",
        type=float,
        nargs=3,
        metavar=("DX", "DY", "DTHETA"),
        help="how far the given pose is off [m, m, rad] (default: -0.1 -0.1 0.3)",
    )
    add_settings(command, "profile")
    command.add_argument(
        "--calibrate",
        type=float,
        metavar="SECONDS",
        help="calibrate each robot first, by a drive of this duration",
    )
    command.add_argument(
        "--world",
        action="append",
        choices=("sim", "as-real", "hand-built", "kinematic"),
        help="may be given more than once (default: sim and as-real; of models sim; kinematic "
        "without a physics engine)",
    )
    command.add_argument(
        "--repeats",
        type=int,
        metavar="N",
        help="how often each motion is driven, of models (default: 20)",
    )
    add_config(command)


def _add_recording(command: argparse.ArgumentParser) -> None:
    """Add the options of a recording, which replaces the simulation."""
    recording = command.add_argument_group("a recording instead of a simulation")
    recording.add_argument(
        "--recording",
        type=Path,
        metavar="FILE",
        help="what was estimated, of models odometry: TUM or KITTI text, a table with a header, "
        "Motive or Vicon CSV, Qualisys TSV, g2o, MRCLAM, or a bag of ROS",
    )
    recording.add_argument(
        "--truth", type=Path, metavar="FILE", help="what was true, in the same forms"
    )
    recording.add_argument(
        "--body", metavar="NAME", help="which rigid body of a motion capture, if it has several"
    )
    recording.add_argument(
        "--clock-offset",
        metavar="SECONDS",
        help="what to add to the recording's stamps; auto estimates it (default: auto)",
    )
    recording.add_argument(
        "--max-time-difference",
        type=float,
        metavar="SECONDS",
        help="largest difference of the stamps of a pair of poses (default: 0.01, and where few "
        "stamps meet, the truth is interpolated)",
    )
    for whose in ("recording", "truth"):
        recording.add_argument(
            f"--{whose}-topic",
            metavar="NAME",
            help=f"which topic of a {whose} that is a bag, or tf:PARENT.CHILD (tf:odom.base_link)",
        )


def _evaluate(parsed: argparse.Namespace) -> int:
    if parsed.what == "integrity":
        from app.features.lab.evaluation.integrity.command import integrity_command  # noqa: PLC0415

        with interruptible():
            return integrity_command(_own_options(vars(parsed)))
    if parsed.what == "navigation":
        from app.features.lab.evaluation.navigation.command import (  # noqa: PLC0415
            navigation_command,
        )

        with interruptible():
            return navigation_command(_own_options(vars(parsed)))
    check_options(vars(parsed))
    if parsed.what == "models":
        from app.features.lab.model_fits.command import models_command  # noqa: PLC0415

        with interruptible():
            return models_command(vars(parsed))
    from app.features.lab.evaluation.command import evaluate_command  # noqa: PLC0415

    with interruptible():
        return evaluate_command(vars(parsed))


def _own_options(given: dict[str, Any]) -> dict[str, Any]:
    """Return the options of what is evaluated; refuse options of the experiment before its name.

    Raises:
        SettingError: an option does not go with it; names the option and the valid ones.
    """
    kind = given["what"]
    valid = OWN_OPTIONS[kind]
    for name in given:
        if name not in (*valid, "out", "what", *NO_OPTIONS):
            options = ", ".join(_option(item) for item in ("out", *valid))
            raise SettingError(f"{_option(name)} does not go with {kind}; valid are {options}")
    for name in ("map", "condition", "start", "trial"):
        if isinstance(given.get(name), str):
            given = given | {name: [given[name]]}
    return given
