"""Small versions of ``bench accuracy``: each fails when its figure is lost.

On rendered pictures and with all imperfections of the simulator; the whole of it takes minutes.
"""

import math

import numpy as np
import pytest

from app.features.lab.evaluation.drives import record
from app.features.lab.evaluation.experiment import KNOWN, in_world
from app.features.lab.evaluation.integrity.oracle import field_decides
from app.features.lab.evaluation.runs import errors, follow
from app.settings.config import Config
from benchmarks.accuracy import (
    CARRIED_FOR,
    FINDERS_AGAIN,
    SETTLED,
    find_again,
    judged,
    lap,
    rms,
    with_filter,
)
from benchmarks.trials import PictureResult, try_filter
from sim.floor_camera import CameraSettings
from sim.simulated import SimSettings

pytestmark = pytest.mark.slow

SEED = 3
SECONDS = 9.0


@pytest.fixture(scope="module")
def drive():
    return record(Config(robot="sim", seed=SEED), SECONDS)


def test_a_robot_whose_camera_is_mounted_askew_is_not_lost():
    """Of the plain square, whose four places look alike: it once ended at one of the others."""
    config = in_world(Config(seed=108), "as-real")
    run = follow(askew := record(config, SECONDS), config, askew.ticks[0].truth, KNOWN)
    assert errors(run, run.estimate)[0].max() < 0.05


def followed(drive, **changes) -> list[PictureResult]:
    shown = try_filter(drive, with_filter(**changes), SEED, drive.ticks[0].truth, KNOWN)
    return [one for one in shown if one.stamp > SETTLED]


@pytest.mark.parametrize("name", ["hypotheses", "particles", "kalman", "grid"])
def test_it_tracks_to_a_millimetre_and_to_a_seventh_of_a_degree(drive, name):
    shown = followed(drive, filter=name)
    assert rms([one.error for one in shown]) < 1e-3
    assert rms([one.turn_error for one in shown]) < math.radians(0.15)
    off = drive.ticks[-1].odometry.distance_to(
        drive.ticks[0].truth.inverse() @ drive.ticks[-1].truth
    )
    assert off > 5e-3, "dead reckoning must not be as good"


def test_laying_the_scan_on_the_edges_makes_the_pose_finer(drive):
    fine, plain = (
        followed(drive, filter="particles"),
        followed(drive, filter="particles", refine=False),
    )
    assert rms([one.turn_error for one in fine]) < 0.8 * rms([one.turn_error for one in plain])
    assert rms([one.error for one in fine]) < rms([one.error for one in plain])


def test_clutter_on_the_floor_does_not_lead_it_astray():
    camera = CameraSettings(clutter="all")
    shown = followed(
        record(Config(robot="sim", seed=SEED, sim=SimSettings(camera=camera)), SECONDS)
    )
    assert rms([one.error for one in shown]) < 2e-3


@pytest.mark.parametrize(("field", "seed"), [("tee", 0), ("stub", 4)])
def test_scattered_on_a_marked_field_it_finds_itself_and_is_not_sure_before(field, seed):
    drive = lap(field, seed)
    assert field_decides(drive, 0.0) < math.inf
    shown = try_filter(drive, with_filter(), seed)
    found = judged(shown, 0.0)
    assert found.right and not found.wrong_claim
    assert np.mean([one.cpu for one in shown]) < 0.01, "by far no figure, only that it is bounded"


def test_on_the_plain_square_it_keeps_all_four_places():
    found = judged(try_filter(lap("square", 1), with_filter(), 1), 0.0)
    assert found.images == 4 and found.even and not found.wrong_claim


@pytest.mark.parametrize(("field", "seed"), [("stub", 0), ("tee", 1)])
def test_carried_off_it_finds_itself_again(field, seed):
    decided, found = find_again((field, seed))
    assert decided < CARRIED_FOR
    ours = found[next(iter(FINDERS_AGAIN))]
    assert ours.right and ours.seconds < CARRIED_FOR
