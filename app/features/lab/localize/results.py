"""Write the results of localizing a bag to a folder."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from app.features.lab.localize.laser_map import LaserMap
from app.features.lab.localize.localized import Localized, ReportedPose
from app.features.lab.localize.picture import draw
from app.features.lab.localize.reading.lasers import BagLaser, Lasers
from app.features.lab.localize.settings import LocalizeSettings
from app.result_files import RESULTS, atomic_folder, write_json
from app.settings.provenance import settings_of, versions
from app.trajectories.trajectory import Trajectory
from app.trajectories.tum_file import write_tum
from robot.geometry import Pose2
from robot.localization.estimate import Hypothesis, State

PATH, WITHDRAWN, PICTURE = "localized.tum", "localized_withdrawn.tum", "path.png"


@dataclass(frozen=True)
class LocalizeRequest:
    """The requested work, which is written beside the result."""

    bag: Path
    map: Path
    seed: int
    settings: LocalizeSettings
    lasers: tuple[BagLaser, ...]
    initial_pose: Pose2 | None
    clock: str


def write_results(
    folder: Path,
    asked: LocalizeRequest,
    localized: Localized,
    laser_map: LaserMap,
    pairing: Lasers,
) -> None:
    """Write all files; the folder gets all of them or stays as it was.

    Raises:
        SettingError: the path cannot be a folder.
        OSError: the folder cannot be written.
    """
    notes = [f"{asked.bag.name} on {asked.map.name}, pose of {asked.lasers[0].layout.base_frame}"]
    wrong = [*notes, "told as certain, and withdrawn: the place turned out wrong"]
    ways = {PATH: (localized.standing, notes, 2), WITHDRAWN: (localized.withdrawn, wrong, 1)}
    with atomic_folder(folder) as new:
        for name, (given, lines, least) in ways.items():
            if len(given) >= least:
                write_tum(new / name, _trajectory(given), lines)
        draw(new / PICTURE, localized, laser_map)
        write_json(new / RESULTS, content(asked, localized, pairing))
    for name, (given, _, least) in ways.items():
        if len(given) < least:
            (folder / name).unlink(missing_ok=True)  # left by an earlier run


def _trajectory(tolds: Sequence[ReportedPose]) -> Trajectory:
    return Trajectory.of_poses(
        [each.stamp for each in tolds], np.array([item.pose for item in tolds])
    )


def content(asked: LocalizeRequest, localized: Localized, pairing: Lasers) -> dict[str, Any]:
    """Return the content of ``results.json``: metres, radians, seconds, map frame."""
    final = localized.final
    return {
        "bag": asked.bag.name,
        "map": asked.map.name,
        "seed": asked.seed,
        "known": localized.known,
        "state": str(localized.state),
        "final": None if final is None else {"stamp": final.stamp, **_place(final.hypotheses[0])},
        "hypotheses": [_place(hypothesis) for hypothesis in final.hypotheses] if final else [],
        "places_left": localized.places_left,
        "known_from": localized.standing[0].stamp if localized.standing else None,
        "scans": {
            "used": localized.scans,
            "known": len(localized.standing),
            "withdrawn": len(localized.withdrawn),
            "by_state": {str(state): localized.states[state] for state in State},
            "first_stamp": _number(localized.first_stamp),
            "last_stamp": _number(localized.last_stamp),
            **vars(pairing.left_out),
        },
        "remarks": pairing.remarks,
        "withdrawn": [
            {"from": first, "to": last, "leader": leader}
            for first, last, leader in localized.spans()
        ],
        "rates": _rates(localized),
        **_read(asked.lasers),
        "initial_pose": _pose(asked.initial_pose) if asked.initial_pose else None,
        "clock": asked.clock,
        "settings": settings_of(asked.settings),
        "versions": versions(),
    }


def _read(lasers: Sequence[BagLaser]) -> dict[str, Any]:
    """Return what was read of the bag; of several lasers, ``lasers`` has each."""
    first = lasers[0]
    result: dict[str, Any] = {
        "topics": {"scan": first.chosen.scan, "odometry": first.chosen.odometry or "tf"},
        "frames": {"base": first.layout.base_frame, **_mounting(first)},
    }
    if len(lasers) > 1:
        result["lasers"] = [{"scan": laser.chosen.scan, **_mounting(laser)} for laser in lasers]
    return result


def _mounting(laser: BagLaser) -> dict[str, Any]:
    return {
        "laser_pose_from": laser.layout.pose_from,
        "base_from_laser": {
            "rotation": laser.layout.base_from_laser.rotation.ravel().tolist(),
            "translation": laser.layout.base_from_laser.translation.tolist(),
        },
    }


def _rates(localized: Localized) -> dict[str, float | int | None]:
    lasted = localized.last_stamp - localized.first_stamp
    return {
        "updates": localized.updates,
        "particles_at_end": localized.particles,
        "filter_s": localized.filter_s,
        "tables_s": localized.tables_s,
        "updates_per_s": localized.updates / localized.filter_s if localized.filter_s else None,
        "times_real_time": lasted / localized.filter_s
        if localized.filter_s and lasted > 0
        else None,
    }


def _pose(pose: Pose2) -> dict[str, float]:
    return {"x": float(pose.x), "y": float(pose.y), "theta": float(pose.theta)}


def _place(hypothesis: Hypothesis) -> dict[str, Any]:
    covariance = hypothesis.covariance.ravel().tolist()
    return {
        "pose": _pose(hypothesis.pose),
        "covariance": covariance,
        "weight": float(hypothesis.weight),
    }


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None
