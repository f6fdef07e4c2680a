"""Benchmark of each design choice of the localization: each is undone alone, on the same drives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from app.features.lab.evaluation.drives import Drive, Tick, record
from app.features.lab.evaluation.experiment import KNOWN
from app.features.lab.trajectories.metrics import rms
from app.settings.config import Config
from benchmarks.accuracy import LAPS, SETTLED, each, find_with, with_filter
from benchmarks.result import Result
from benchmarks.trials import setup_of, try_filter
from robot.description.spec import RobotSpec
from robot.geometry import Twist2
from robot.interface import Frame
from robot.localization.filter import Setup
from robot.localization.models.entry_field import EntryField
from robot.localization.models.sensor_models import SensorParameters, sensor_model
from robot.localization.parameters import LocalizationParameters
from robot.scanning.line_scanner import LineScan, LineScanner

SEEDS = range(6)
GLOBAL_SEEDS = range(12)
ONE_CLOUD = with_filter(filter="particles", refine=False)
"""A plain particle filter to measure tracking: hypotheses elsewhere would disturb, and the
refinement would hide the effect on the cloud."""

Undo = Callable[[Setup], Setup]


def as_it_is(setup: Setup) -> Setup:
    """Return the setup unchanged."""
    return setup


def no_direction(setup: Setup) -> Setup:
    """Let an edge attract the ends of rays from any direction."""
    nearest = np.abs(setup.entries.distances).min(axis=0)
    same = np.broadcast_to(nearest, setup.entries.distances.shape).copy()
    return with_entries(setup, replace(setup.entries, distances=same))


def no_sign(setup: Setup) -> Setup:
    """Remove the sign of distances, so that distances bend within the cells at edges."""
    return with_entries(setup, replace(setup.entries, distances=np.abs(setup.entries.distances)))


def with_entries(setup: Setup, entries: EntryField) -> Setup:
    """Return the setup with another table of distances."""
    sensor = sensor_model(setup.parameters.sensor, entries, setup.field.edges)
    return replace(setup, entries=entries, sensor=sensor)


def no_negative_evidence(setup: Setup) -> Setup:
    """Ignore edges that should be seen and are not."""
    return replace(setup, evidence=setup.evidence._replace(missed=1.0))


class Skewed(LineScanner):
    """A scanner that does not correct the rolling shutter's skew."""

    def __init__(self) -> None:
        super().__init__(RobotSpec.load().floor_view, Config().scanner)

    def scan(self, frame: Frame, twist: Twist2 = Twist2()) -> LineScan:
        """Scan a picture as if the robot stood still."""
        return super().scan(frame)


def late(drive: Drive) -> Drive:
    """Return a drive whose scans are stamped at arrival instead of at exposure."""
    return Drive(drive.field, [_late(tick) for tick in drive.ticks])


def _late(tick: Tick) -> Tick:
    if tick.scan is None:
        return tick
    assert tick.line_scan is not None
    line_scan = replace(tick.line_scan, scan=replace(tick.scan, stamp=tick.stamp))
    return replace(tick, line_scan=line_scan, odometry_at_scan=tick.odometry)


def sensor(**changes: float) -> LocalizationParameters:
    """Return the parameters of one cloud, with some changed parameters of the sensor."""
    return replace(ONE_CLOUD, sensor=replace(SensorParameters(), **changes))  # type: ignore[arg-type]


@dataclass(frozen=True)
class Choice:
    """A design choice that is changed: parameters, setup or drive."""

    parameters: LocalizationParameters = ONE_CLOUD
    undo: Undo = as_it_is
    drive: Callable[[Drive], Drive] | None = None


CHOICES = {
    "as it is": Choice(),
    "refined": Choice(with_filter(filter="particles")),
    "edges without direction": Choice(undo=no_direction),
    "distances without sign": Choice(undo=no_sign),
    "cells of 10 mm": Choice(sensor(field_resolution=0.01)),
    "cells of 20 mm": Choice(sensor(field_resolution=0.02)),
    "exposed when the picture arrives": Choice(drive=late),
    "sigma_hit 20 mm": Choice(sensor(sigma_hit=0.02)),
    "100 particles": Choice(
        with_filter(filter="particles", refine=False, min_particles=100, max_particles=100)
    ),
    "15 beams": Choice(sensor(max_beams=15)),
    "copies not spread": Choice(with_filter(filter="particles", refine=False, regularization=0.0)),
}


def track(seed: int) -> dict[str, float]:
    """Return errors [m] of one robot over two laps, with each choice and with uncorrected skew."""
    drive = record(Config(robot="sim", seed=seed), LAPS)
    skewed = record(Config(robot="sim", seed=seed), LAPS, scanner=Skewed())
    errors = {name: error(choice, drive, seed) for name, choice in CHOICES.items()}
    errors["readout not corrected"] = error(Choice(), skewed, seed)
    return errors


def error(choice: Choice, drive: Drive, seed: int) -> float:
    """Return the root mean square of the position error [m]."""
    seen = choice.drive(drive) if choice.drive else drive
    setup = choice.undo(setup_of(drive.field, choice.parameters))
    shown = try_filter(seen, choice.parameters, seed, drive.ticks[0].truth, KNOWN, setup=setup)
    return rms([picture.error for picture in shown if picture.stamp > SETTLED])


def measure() -> Result:
    """Measure tracking with each choice undone, and global starts without negative evidence."""
    runs = each(track, SEEDS)
    more = {}
    for name in runs[0]:
        errors = [1e3 * run[name] for run in runs]
        more[f"{name} [mm]"] = float(np.mean(errors))
        more[f"{name}, worst robot [mm]"] = max(errors)
    for name, undo in (("with", as_it_is), ("without", no_negative_evidence)):
        outcomes = each(partial(find_with, undo), [("tee", seed) for seed in GLOBAL_SEEDS])
        start = f"global start, tee, {name} negative evidence"
        more[f"{start}: right, of {len(outcomes)}"] = sum(outcome.right for outcome in outcomes)
        more[f"{start}: first sure claim wrong"] = sum(outcome.wrong_claim for outcome in outcomes)
        seconds = [outcome.seconds for outcome in outcomes]
        more[f"{start}: mean until right for good [s]"] = float(np.mean(seconds))
    return Result("mm position error (RMSE) tracking", more["as it is [mm]"], more=more)
