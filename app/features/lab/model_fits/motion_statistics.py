"""Statistics of odometry and of the motion model, from repeated motions or from a recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from tqdm import tqdm

from app.engine.robots import robot_kind
from app.features.lab.evaluation.drives import EvaluationError
from app.features.lab.evaluation.experiment import in_world
from app.features.lab.model_fits.likelihood import FitError
from app.features.lab.model_fits.motion_fit import DriveFit, fit_drive
from app.features.lab.model_fits.motions import DriveCorrection, MotionRun, cut_at, paired_runs
from app.features.lab.model_fits.regions import Held, fit_region, held_by, usable_horizons
from app.features.lab.model_fits.simulated_motions import SIDE, TrialRobot, run_motion, trials
from app.features.lab.model_fits.umbmark import Umbmark, distance_factor, return_errors, umbmark
from app.features.lab.model_fits.windows import windows
from app.features.lab.workers import Workers
from app.settings.config import Config
from app.trajectories.trajectory import Trajectory
from robot.description.spec import RobotSpec
from robot.driving.differential_drive import WheelMultipliers
from robot.geometry import Array
from sim.imperfections import draw


@dataclass(frozen=True, eq=False)
class EndSpread:
    """Errors at the end of a motion that is driven several times."""

    motion: str
    errors: Array
    """(n, 3) [m, m, rad]: the true end seen from the end by odometry, as a twist: along, across,
    heading."""
    predicted: Array
    """(3, 3): their covariance by the motion model, the mean over the runs."""
    distances: Array
    """(n,): squared Mahalanobis distances of the errors by the model's covariance of each run; the
    mean is 3 if the model is right."""


@dataclass(frozen=True)
class MotionStatistics:
    """Odometry's systematic errors, the alphas of the remaining errors, and tests of both."""

    fit: DriveFit
    umbmark: Umbmark | None
    """None without squares."""
    multipliers: WheelMultipliers
    """The fitted correction of the wheels."""
    true: WheelMultipliers | None
    """The true correction; only a simulator knows it."""
    ends: tuple[tuple[EndSpread, EndSpread], ...]
    """For each motion its ends: by the model as it is set, and by the corrected and fitted one."""
    held: tuple[Held, ...]
    """Regions fitted to the first half of a recording, tested on the second half."""
    clock_offset: float
    """Time added to odometry's stamps [s]."""


def repeated_motions(
    config: Config, world: str, repeats: int, workers: Workers
) -> MotionStatistics:
    """Drive each motion many times with one simulated robot, that of ``sim.imperfections.robot``.

    Raises:
        EvaluationError: a motion cannot be driven.
        FitError: there are too few repeats.
    """
    spec, config = RobotSpec.load(), in_world(config, world)
    robot = trial_robot(spec, config)
    drives = _driven(robot, repeats, workers)
    even = [run.resampled(1 / config.sim.camera.frame_rate) for run in drives]
    fit, motion = fit_drive(even, track=spec.track), config.localization.motion
    as_set = np.array([motion.alpha1, motion.alpha2, motion.alpha3, motion.alpha4, 0.0, 0.0])
    as_set_ends = end_spreads(even, as_set, DriveCorrection(track=spec.track))
    fitted_ends = end_spreads(even, fit.motion.factors, fit.correction)
    return MotionStatistics(
        fit,
        _umbmark(drives, spec.track),
        fit.correction.wheel_multipliers(),
        _true_multipliers(spec, robot.true),
        tuple(zip(as_set_ends, fitted_ends, strict=True)),
        (),
        0.0,
    )


def trial_robot(spec: RobotSpec, config: Config) -> TrialRobot:
    """Return the robot that the configuration's seed draws, for motions without a camera."""
    seed, imperfect = max(config.sim.imperfections.robot, 0), config.sim.imperfections
    true = draw(spec, imperfect, np.random.default_rng(seed))
    return TrialRobot(
        spec,
        true,
        imperfect,
        config.drive,
        config.sim.physics,
        robot_kind(config).has_forces,
        config.sim.engine,
        seed,
    )


def end_spreads(
    runs: Sequence[MotionRun], factors: Array, correction: DriveCorrection
) -> list[EndSpread]:
    """Return the ends of runs, one entry for each motion in order of appearance.

    Runs need the even stamps that the model's alphas are for. The factors (6,) are those of
    windows.

    Raises:
        FitError: a motion was driven only once.
    """
    spreads = []
    for name in dict.fromkeys(run.name for run in runs):
        same = [run for run in runs if run.name == name]
        if len(same) < 2:
            raise FitError(f"{name} was driven {len(same)} time; a spread needs 2 or more")
        longest = max(run.duration for run in same)
        ends = windows(same, longest, correction, stride=longest, keep_short=True)
        covariances = ends.covariances(factors)
        # A run that stands still has no spread and no error.
        inverses = np.linalg.pinv(covariances, hermitian=True)
        distances = np.einsum("ni,nij,nj->n", ends.errors, inverses, ends.errors)
        spreads.append(EndSpread(name, ends.errors, covariances.mean(axis=0), distances))
    return spreads


def recorded_motion(
    odometry: Trajectory, truth: Trajectory, clock_offset: float, config: Config
) -> MotionStatistics:
    """Fit to the first half of a recording, and test the fit on the second half.

    The clock offset [s] is added to odometry's stamps. Odometry was computed with the wheel
    multipliers of the configuration, so the fit corrects these further.

    Raises:
        FitError: the robot drives or turns too little; says what is needed.
    """
    believed = config.drive.multipliers
    tracks = odometry.stamps, odometry.poses, truth.stamps, truth.poses
    runs = paired_runs(*tracks, step=1 / config.sim.camera.frame_rate, offset=clock_offset)
    first, second = cut_at(runs, (runs[0].stamps[0] + runs[-1].stamps[-1]) / 2)
    fit = fit_drive(first, track=believed.separation * robot_kind(config).description().track)
    horizons = [horizon for horizon in usable_horizons(first) if horizon in usable_horizons(second)]
    model = fit.correction, fit.motion
    held = [held_by(second, *model, fit_region(first, *model, horizon)) for horizon in horizons]
    more = fit.correction.wheel_multipliers()
    wheels = WheelMultipliers(*(a * b for a, b in zip(believed, more, strict=True)))
    return MotionStatistics(fit, None, wheels, None, (), tuple(held), clock_offset)


def _driven(robot: TrialRobot, repeats: int, workers: Workers) -> list[MotionRun]:
    jobs, runs = trials(robot, repeats), dict[int, MotionRun]()
    results = workers.each(run_motion, jobs)
    for place, run in tqdm(results, total=len(jobs), unit="motion", disable=None):
        if isinstance(run, Exception):
            raise EvaluationError(f"{jobs[place].motion}: {run}") from run
        runs[place] = run
    return [runs[place] for place in sorted(runs)]


def _umbmark(runs: Sequence[MotionRun], track: float) -> Umbmark:
    cw, ccw = (return_errors([r for r in runs if r.name == f"square_{w}"]) for w in ("cw", "ccw"))
    straight = distance_factor([run for run in runs if run.name.startswith("straight")])
    return umbmark(cw, ccw, SIDE, track, straight)


def _true_multipliers(spec: RobotSpec, true: RobotSpec) -> WheelMultipliers:
    left, right = (true.joints[side].radius / spec.joints[side].radius for side in spec.axle)
    return WheelMultipliers(left, right, true.track / spec.track)
