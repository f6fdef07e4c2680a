"""What ``brickpose evaluate`` does with its arguments."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from app.batch.workers import Workers, workers
from app.config import Config, load_config
from app.evaluation.evaluate import evaluate
from app.evaluation.experiment import Experiment
from app.evaluation.recorded import evaluate_recording
from app.evaluation.report.report import millimetres, seconds
from robot.settings import SettingError
from sim.bullet import BulletMissingError, load_pybullet


def evaluate_command(parsed: argparse.Namespace) -> int:
    """Make the experiment, or compare a recording."""
    recording = recording_of(parsed)
    if recording is not None:
        files = recording.estimate, recording.truth
        results = evaluate_recording(*files, parsed.out, recording.body, parsed.clock_offset)
        ate = {key: results["methods"]["amcl"][key]["mean"] for key in ATE}
        added = results["experiment"]["clock_offset_added_s"]
        say(f"{', '.join(f'{ATE[key]} {millimetres(value)}' for key, value in ate.items())}")
        say(f"{added:.4f} s was added to the recording's stamps")
    else:
        experiment = Experiment(
            config_of(parsed),
            worlds_of(parsed),
            parsed.first_seed,
            parsed.seeds,
            parsed.laps,
            tuple(parsed.offset),
        )
        crew = crew_of(parsed)
        try:
            results = evaluate(experiment, crew, parsed.out)
        finally:
            crew.close()
        for condition in results["conditions"]:
            say(_line(condition))
    say(f"the report is {parsed.out / 'report.html'}")
    return 0


ATE = {"ate_rmse_m": "unaligned", "ate_aligned_rmse_m": "aligned"}


class RecordingFiles(NamedTuple):
    """What the command line names of a recording."""

    estimate: Path
    truth: Path
    body: str | None


def recording_of(parsed: argparse.Namespace) -> RecordingFiles | None:
    """The recording that is to be compared; None for a simulation.

    Raises:
        SettingError: only one of its two files was named.
    """
    given = vars(parsed)
    if ("recording" in given) != ("truth" in given):
        raise SettingError("--recording and --truth are given together")
    if "recording" not in given:
        return None
    return RecordingFiles(given["recording"], given["truth"], given.get("body"))


def config_of(parsed: argparse.Namespace) -> Config:
    """The configuration file, if there is one, with the map of the command line."""
    given = vars(parsed)
    config = load_config(given["config"]) if "config" in given else Config()
    return replace(config, map=given["map"]) if "map" in given else config


def worlds_of(parsed: argparse.Namespace) -> tuple[str, ...]:
    """Those of the command line, or what can be had here."""
    given = tuple(dict.fromkeys(vars(parsed).get("world", ())))
    if given:
        return given
    try:
        load_pybullet()
    except BulletMissingError as error:
        say(f"In the kinematic world, with perfect wheels: {error}")
        return ("kinematic",)
    return ("sim", "as-real")


def crew_of(parsed: argparse.Namespace) -> Workers:
    """Who does the work."""
    given = vars(parsed)
    return workers(given.get("workers"), given.get("cluster"))


def say(text: str) -> None:
    """A line for people."""
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


def _line(condition: dict[str, Any]) -> str:
    told = "known" if condition["offset"] is None else "told wrong"
    ate = {name: one["ate_rmse_m"]["mean"] for name, one in condition["methods"].items()}
    after = condition["convergence"]
    median = after["seconds"]["median"]
    return (
        f"{condition['world']}, start {told}: "
        f"odometry {millimetres(ate['odometry'])}, AMCL {millimetres(ate['amcl'])}; "
        f"{after['converged']} of {after['of']} right, after {seconds(median)}, "
        f"then {millimetres(after['steady_ate_rmse_m']['mean'])}"
    )
