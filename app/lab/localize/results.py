"""What a bag's localization leaves in a folder."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from app.files import RESULTS, write_json, written_whole
from app.lab.localize.found import Localized, Told
from app.lab.localize.laser_map import LaserMap
from app.lab.localize.picture import draw
from app.lab.localize.reading.mounting import Layout
from app.lab.localize.reading.pairing import LeftOut
from app.lab.localize.reading.topics import Chosen
from app.lab.localize.settings import LocalizeSettings
from app.lab.trajectories.files.tum import write_tum
from app.lab.trajectories.trajectory import Trajectory
from app.settings.provenance import settings_of, versions
from robot.geometry import Pose2
from robot.localization.estimate import Hypothesis
from robot.localization.integrity import State

PATH, WITHDRAWN, PICTURE = "localized.tum", "localized_withdrawn.tum", "path.png"


@dataclass(frozen=True)
class Asked:
    """What was to be done, to be written beside the result."""

    bag: Path
    map: Path
    seed: int
    settings: LocalizeSettings
    chosen: Chosen
    layout: Layout
    initial_pose: Pose2 | None
    clock: str


def write_results(
    folder: Path, asked: Asked, found: Localized, on: LaserMap, left_out: LeftOut
) -> None:
    """Write all, so that the folder has all of it or is as it was.

    Raises:
        SettingError: the folder cannot be one.
        OSError: it cannot be written.
    """
    notes = [f"{asked.bag.name} on {asked.map.name}, pose of {asked.layout.base_frame}"]
    wrong = [*notes, "told as certain, and withdrawn: the place turned out wrong"]
    ways = {PATH: (found.standing, notes, 2), WITHDRAWN: (found.withdrawn, wrong, 1)}
    with written_whole(folder) as new:
        for name, (told, lines, least) in ways.items():
            if len(told) >= least:
                write_tum(new / name, _trajectory(told), lines)
        draw(new / PICTURE, found, on)
        write_json(new / RESULTS, content(asked, found, left_out))
    for name, (told, _, least) in ways.items():
        if len(told) < least:
            (folder / name).unlink(missing_ok=True)  # of an earlier run


def _trajectory(told: Sequence[Told]) -> Trajectory:
    return Trajectory.of_poses([one.stamp for one in told], np.array([one.pose for one in told]))


def content(asked: Asked, found: Localized, left_out: LeftOut) -> dict[str, Any]:
    """``results.json``: metres, radians, seconds, map frame."""
    final = found.final
    return {
        "bag": asked.bag.name,
        "map": asked.map.name,
        "seed": asked.seed,
        "known": found.known,
        "state": str(found.state),
        "final": None if final is None else {"stamp": final.stamp, **_place(final.hypotheses[0])},
        "hypotheses": [_place(one) for one in final.hypotheses] if final else [],
        "places_left": found.places_left,
        "known_from": found.standing[0].stamp if found.standing else None,
        "scans": {
            "used": found.scans,
            "known": len(found.standing),
            "withdrawn": len(found.withdrawn),
            "by_state": {str(state): found.states[state] for state in State},
            "first_stamp": _number(found.first_stamp),
            "last_stamp": _number(found.last_stamp),
            **vars(left_out),
        },
        "withdrawn": [
            {"from": first, "to": last, "leader": leader} for first, last, leader in found.spans()
        ],
        "rates": _rates(found),
        "topics": {"scan": asked.chosen.scan, "odometry": asked.chosen.odometry or "tf"},
        "frames": {
            "base": asked.layout.base_frame,
            "laser_pose_from": asked.layout.told_by,
            "base_from_laser": {
                "rotation": asked.layout.base_from_laser.rotation.ravel().tolist(),
                "translation": asked.layout.base_from_laser.translation.tolist(),
            },
        },
        "initial_pose": _pose(asked.initial_pose) if asked.initial_pose else None,
        "clock": asked.clock,
        "settings": settings_of(asked.settings),
        "versions": versions(),
    }


def _rates(found: Localized) -> dict[str, float | int | None]:
    lasted = found.last_stamp - found.first_stamp
    return {
        "updates": found.updates,
        "particles_at_end": found.particles,
        "filter_s": found.filter_s,
        "tables_s": found.tables_s,
        "updates_per_s": found.updates / found.filter_s if found.filter_s else None,
        "times_real_time": lasted / found.filter_s if found.filter_s and lasted > 0 else None,
    }


def _pose(pose: Pose2) -> dict[str, float]:
    return {"x": float(pose.x), "y": float(pose.y), "theta": float(pose.theta)}


def _place(one: Hypothesis) -> dict[str, Any]:
    covariance = one.covariance.ravel().tolist()
    return {"pose": _pose(one.pose), "covariance": covariance, "weight": float(one.weight)}


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None
