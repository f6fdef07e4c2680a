"""What ``brickpose evaluate models`` does with its arguments."""

from __future__ import annotations

import argparse

from app.evaluation.command import config_of, crew_of, recording_of, say, worlds_of
from app.evaluation.recorded import clock_of
from app.evaluation.report.report import millimetres
from app.model_fits.models import FITTED, ModelsJob, evaluate_models, evaluate_recorded_models
from robot.settings import SettingError


def models_command(parsed: argparse.Namespace) -> int:
    """Measure one simulated robot, or a recording."""
    config = config_of(parsed)
    recording = recording_of(parsed)
    if recording is not None:
        results = evaluate_recorded_models(
            recording.estimate,
            recording.truth,
            parsed.out,
            recording.body,
            clock_of(parsed.clock_offset),
            config,
        )
        for region in results["motion"]["regions"]:
            say(
                f"the 95 % region over {region['horizon']:g} s held {region['held']:.1%} of the "
                "second half"
            )
    else:
        for name in ("repeats", "seeds", "first_seed"):
            least = 0 if name == "first_seed" else 2
            if getattr(parsed, name) < least:
                raise SettingError(f"{name} is {getattr(parsed, name)}; valid is {least} or more")
        job = ModelsJob(
            config, worlds_of(parsed)[0], parsed.first_seed, parsed.repeats, parsed.seeds
        )
        crew = crew_of(parsed)
        try:
            results = evaluate_models(job, crew, parsed.out)
        finally:
            crew.close()
        for name, tables in results["compared"].items():
            ate = tables["known"]["methods"]
            say(
                f"{name} settings: odometry {millimetres(ate['odometry']['ate_rmse_m']['mean'])}, "
                f"AMCL {millimetres(ate['amcl']['ate_rmse_m']['mean'])}"
            )
    alphas = results["motion"]["alphas"]
    say(", ".join(f"{name} {one['value']:.4g}" for name, one in alphas.items()))
    say(f"fitted parameters are in {parsed.out / FITTED}, for --config")
    say(f"the report is {parsed.out / 'report.html'}")
    return 0
