"""A robot knows its place in a map that it drew itself, and in which tape is missing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from mappings import field_of, laid_on, mapped
from simulators import require_engine

from app.features.lab.evaluation.drives import follow_drive
from app.features.lab.evaluation.integrity.drives import NONE, lap_drive
from app.settings.config import MAPS, Config
from robot.fields.field import Field
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.localization.estimate import BOUNDED

pytestmark = pytest.mark.slow

KNOWN = np.diag([1e-4, 1e-4, 1e-3])


@pytest.mark.parametrize("seed", [9501, 9502, 9509])
def test_where_nobody_looked_tape_neither_is_due_nor_forbidden(seed: int) -> None:
    """Of *tee*, a figure-eight of 12 s shows no end of two strokes, and not all of the right."""
    own, floor_from_map = own_map("tee", 9001, 12.0)
    error, certain = followed(own, floor_from_map, "tee", seed)
    assert error < 0.004
    assert certain == 1.0
    if seed == 9501:
        doubted, _ = followed(replace(own, seen=()), floor_from_map, "tee", seed)
        assert doubted > 10 * error


def test_a_place_on_floor_that_nobody_looked_at_is_not_refuted_by_one_that_was_drawn() -> None:
    """Of *square*, a corner was not drawn: each of the others looks like the true one."""
    own, floor_from_map = own_map("square", 9113, 6.0)
    error, certain = followed(own, floor_from_map, "square", 9612, scattered=True)
    assert error > 0.05, "it cannot be known here"
    assert certain == 0.0


def own_map(name: str, seed: int, seconds: float) -> tuple[Field, Pose2]:
    require_engine("mujoco")
    drawn, poses = mapped(name, seed, seconds=seconds)
    return field_of(drawn), laid_on(drawn, poses, load_field(name, MAPS))


def followed(
    believed: Field, floor_from_map: Pose2, name: str, seed: int, *, scattered: bool = False
) -> tuple[float, float]:
    """Root mean square of the distances from the truth [m], and the share of certain pictures."""
    config = Config(robot="sim", map=name, seed=seed)
    drive = lap_drive(config, 2, NONE).drive
    start = floor_from_map.inverse() @ drive.ticks[0].truth
    offsets, states = [], []
    for tick, _, localization in follow_drive(
        drive,
        config,
        lambda it: it.scatter() if scattered else it.set_pose(start, KNOWN),
        believed=believed,
    ):
        assert tick.scan is not None and tick.odometry_at_scan is not None
        states.append(localization.integrity.state)
        if localization.belief is None:
            continue
        pose = localization.belief.pose(tick.odometry_at_scan)
        offsets.append((floor_from_map @ pose).distance_to(drive.truth_at(tick.scan.stamp)))
    rms = float(np.sqrt(np.mean(np.square(offsets))))
    return rms, float(np.mean([state in BOUNDED for state in states]))
