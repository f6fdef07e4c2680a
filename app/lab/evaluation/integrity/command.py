"""Carries out ``brickpose evaluate integrity`` with its arguments."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from app.console import say
from app.lab.evaluation.command import workers_from_options
from app.lab.evaluation.integrity.evaluate_integrity import evaluate_integrity
from app.lab.evaluation.integrity.experiment import IntegrityExperiment
from app.lab.workers import Workers
from app.settings.config import Config, load_config
from robot.errors import PackageError
from sim.bullet import load_pybullet

OUT = Path("evaluation") / "integrity"
SEVERAL = {"map": "maps", "condition": "conditions", "start": "starts"}
SINGLE = ("first_seed", "seeds", "laps")


def integrity_command(given: dict[str, Any]) -> int:
    """Run the experiment."""
    folder = given.get("out", OUT)
    options: dict[str, Any] = {name: given[name] for name in SINGLE if name in given}
    for option, name in SEVERAL.items():
        if option in given:
            options[name] = tuple(dict.fromkeys(given[option]))
    experiment = IntegrityExperiment(_config(given), **options)
    crew: Workers = workers_from_options(given)
    try:
        results = evaluate_integrity(experiment, crew, folder)
    finally:
        crew.close()
    for group in results["summary"]["groups"]:
        say(_line(group))
    for result in results["failures"]:
        say(
            f"failed: seed {result['seed']} on {result['map']}, {result['condition']}: "
            f"{result['error']}"
        )
    say(f"the report is {folder / 'report.html'}")
    return 0


def _config(given: dict[str, Any]) -> Config:
    config = load_config(given["config"]) if "config" in given else Config()
    try:
        load_pybullet()
    except PackageError as error:
        say(f"In the kinematic world, with perfect wheels: {error}")
        return replace(config, robot="kinematic")
    return config


def _line(group: dict[str, Any]) -> str:
    drives = group["drives"]
    return (
        f"{group['condition']}, {group['start']}: misleading {100 * group['misleading']:.3f} %, "
        f"longest {group['misleading_longest_s']:.1f} s; sure {100 * group['sure']:.1f} %; "
        f"lost again {group['lost_again_drives']}, "
        f"right to the end {group['right_to_the_end_drives']} of {drives}"
    )
