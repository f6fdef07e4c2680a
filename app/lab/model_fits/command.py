"""Carries out ``brickpose evaluate models`` with its arguments."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from app.console import say
from app.lab.evaluation.command import Given, workers_from_options, worlds_from_options
from app.lab.evaluation.recorded import clock_of
from app.lab.evaluation.report.report import millimetres
from app.lab.model_fits.models import FITTED, ModelsJob, evaluate_models, evaluate_recorded_models
from app.options import config_of
from robot.settings import SettingError

OUT = Path("evaluation") / "models"
LIMITS = {"repeats": (2, 10_000), "seeds": (2, 10_000), "first_seed": (0, 2**31)}


def models_command(given: Given) -> int:
    """Measure one simulated robot, or evaluate a recording."""
    folder = given.get("out", OUT)
    if "recording" in given:
        files = given["recording"], given["truth"]
        clock = clock_of(given.get("clock_offset", "auto"))
        results = evaluate_recorded_models(
            *files, folder, given.get("body"), clock, config_of(given)
        )
        for region in results["motion"]["regions"]:
            say(_region_line(region))
    else:
        results = _simulated(given, folder)
        for name, tables in results["compared"].items():
            ate = tables["known"]["methods"]
            say(
                f"{name} settings: odometry {millimetres(ate['odometry']['ate_rmse_m']['mean'])}, "
                f"AMCL {millimetres(ate['amcl']['ate_rmse_m']['mean'])}"
            )
    alphas = results["motion"]["alphas"]
    say(", ".join(f"{name} {fit['value']:.4g}" for name, fit in alphas.items()))
    say(f"fitted parameters are in {folder / FITTED}, for --config")
    say(f"the report is {folder / 'report.html'}")
    return 0


def _region_line(region: dict[str, Any]) -> str:
    low, high = region["held_interval"]
    return (
        f"the 95 % region over {region['horizon']:g} s held {region['held']:.1%} of the second "
        f"half ({low:.1%} to {high:.1%}, as of {region['held_independent']:.0f} independent "
        f"windows): {region['judgement']}"
    )


def _simulated(given: Given, folder: Path) -> dict[str, Any]:
    for name, (low, high) in LIMITS.items():
        if name in given and not low <= given[name] <= high:
            option = "--" + name.replace("_", "-")
            raise SettingError(f"{option} is {given[name]}; valid is {low} to {high}")
    worlds = worlds_from_options(given)
    if len(given.get("world", ())) > 1:
        raise SettingError("models are measured in one --world")
    job = ModelsJob(
        config_of(given),
        worlds[0],
        given.get("first_seed", 0),
        given.get("repeats", 20),
        given.get("seeds", 6),
    )
    crew = workers_from_options(given)
    try:
        return evaluate_models(job, crew, folder)
    finally:
        crew.close()
