"""What repeated motions, or a recording, tell of odometry and of the motion model."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from tqdm import tqdm

from app.lab.evaluation.drives import EvaluationError
from app.lab.evaluation.worlds import in_world
from app.lab.model_fits.motion.coverage import fit_regions, usable_horizons
from app.lab.model_fits.motion.drive_correction import DriveCorrection
from app.lab.model_fits.motion.drive_fit import DriveFit, fit_drive
from app.lab.model_fits.motion.held import Held, held_by
from app.lab.model_fits.motion.run import MotionRun, cut_at, paired_runs
from app.lab.model_fits.trials.motions import SIDE
from app.lab.model_fits.trials.spread import EndSpread, end_spreads
from app.lab.model_fits.trials.trials import TrialRobot, run_motion, trials
from app.lab.model_fits.trials.umbmark import Umbmark, distance_factor, return_errors, umbmark
from app.lab.trajectories.trajectory import Trajectory
from app.lab.workers import Workers
from app.settings.config import Config
from robot.description.spec import RobotSpec
from robot.driving.differential_drive import WheelMultipliers
from robot.localization.models.differential_motion import DifferentialMotion
from sim.imperfections import draw


@dataclass(frozen=True)
class MotionStatistics:
    """Odometry's steady errors, the alphas of what is left, and how both do."""

    fit: DriveFit
    umbmark: Umbmark | None
    """None without squares."""
    multipliers: WheelMultipliers
    """What the wheels are corrected by, as fitted to all that was driven."""
    true: WheelMultipliers | None
    """What they should be; only a simulator knows."""
    ends: tuple[tuple[EndSpread, EndSpread], ...]
    """For each motion its ends: by the model as it is set, and corrected and fitted."""
    held: tuple[Held, ...]
    """Regions fitted to the first half of a recording, and what they held of the second."""
    clock_offset: float
    """What was added to odometry's stamps [s]."""


def repeated_motions(
    config: Config, world: str, repeats: int, workers: Workers
) -> MotionStatistics:
    """Drive each motion many times with one simulated robot.

    Args:
        config: ``sim.imperfections.robot`` is which one.
        world: one of ``WORLDS``.
        repeats: how often each motion is driven.
        workers: who does it.

    Raises:
        EvaluationError: a motion cannot be driven.
        FitError: too few repeats to tell.
    """
    spec, config = RobotSpec.load(), in_world(config, world)
    robot = trial_robot(spec, config)
    jobs = trials(robot, repeats)
    runs: dict[int, MotionRun] = {}
    for place, done in tqdm(
        workers.each(run_motion, jobs), total=len(jobs), unit="motion", disable=None
    ):
        if isinstance(done, Exception):
            raise EvaluationError(f"{jobs[place].motion}: {done}") from done
        runs[place] = done
    step = 1 / config.sim.camera.frame_rate
    driven = [runs[place] for place in sorted(runs)]
    even = [run.resampled(step) for run in driven]
    fit = fit_drive(even, track=spec.track)
    squares = _umbmark(driven, spec.track)
    motion = config.localization.motion
    as_set = DifferentialMotion(motion.alpha1, motion.alpha2, motion.alpha3, motion.alpha4)
    before = end_spreads(even, as_set, DriveCorrection(track=spec.track))
    after = end_spreads(
        even, fit.motion.model(), fit.correction, (fit.motion.floor_xy, fit.motion.floor_theta)
    )
    return MotionStatistics(
        fit,
        squares,
        fit.correction.wheel_multipliers(spec.track),
        _true_multipliers(spec, robot.true),
        tuple(zip(before, after, strict=True)),
        (),
        0.0,
    )


def trial_robot(spec: RobotSpec, config: Config) -> TrialRobot:
    """The robot that a configuration draws, for motions without a camera."""
    imperfections, physics = config.sim.imperfections, config.sim.physics
    seed = max(imperfections.robot, 0)
    if config.robot == "kinematic":
        exact = replace(imperfections, slip_sd=0.0, encoder_step=0.0)
        return TrialRobot(spec, spec, exact, config.drive, physics, "kinematic", seed)
    true = draw(spec, imperfections, np.random.default_rng(seed))
    return TrialRobot(spec, true, imperfections, config.drive, physics, "sim", seed)


def recorded_motion(
    odometry: Trajectory, truth: Trajectory, clock_offset: float, config: Config
) -> MotionStatistics:
    """Fit to the first half of a recording, and try it on the second.

    Args:
        odometry: the robot in the odom frame.
        truth: the robot in any frame of the floor.
        clock_offset: what to add to odometry's stamps [s].
        config: with which odometry was reckoned; its wheel multipliers are corrected further.

    Raises:
        FitError: too little was driven, or turned; says what is needed.
    """
    believed = config.drive.multipliers
    track = believed.separation * RobotSpec.load().track
    runs = paired_runs(
        odometry.stamps,
        odometry.poses,
        truth.stamps,
        truth.poses,
        step=1 / config.sim.camera.frame_rate,
        offset=clock_offset,
    )
    middle = (runs[0].stamps[0] + runs[-1].stamps[-1]) / 2
    first, second = cut_at(runs, middle)
    fit = fit_drive(first, track=track)
    horizons = [h for h in usable_horizons(first) if h in usable_horizons(second)]
    regions = fit_regions(first, fit.correction, fit.motion, horizons=horizons)
    held = tuple(held_by(second, fit.correction, fit.motion, region) for region in regions)
    more = fit.correction.wheel_multipliers(track)
    wheels = WheelMultipliers(*(a * b for a, b in zip(believed, more, strict=True)))
    return MotionStatistics(fit, None, wheels, None, (), held, clock_offset)


def _umbmark(runs: list[MotionRun], track: float) -> Umbmark:
    by_name = {name: [run for run in runs if run.name == name] for name in {r.name for r in runs}}
    straight = by_name["straight_forward"] + by_name["straight_back"]
    return umbmark(
        return_errors(by_name["square_cw"]),
        return_errors(by_name["square_ccw"]),
        SIDE,
        track,
        distance_factor(straight),
    )


def _true_multipliers(spec: RobotSpec, true: RobotSpec) -> WheelMultipliers:
    left, right = (true.joints[side].radius / spec.joints[side].radius for side in spec.axle)
    return WheelMultipliers(left, right, true.track / spec.track)
