"""Long drives: pictures of places that are known are laid on the map, and not adjusted."""

import numpy as np
import pytest
from calibrations import SPEC, SQUARE, driven
from mappings import WIDTH, Tour, errors_of

from robot.geometry import Array
from robot.mapping.mapper import Mapper
from robot.mapping.passing import PASSES, Bridges, Followed, SeenBefore

LAPS_S = 125.0
"""Laps of a tour of the square, three each way and more [s]."""


def before(passes: int, share: float = 1.0) -> SeenBefore:
    stamps = 20.0 * np.arange(passes)
    poses = np.zeros((passes, 3))
    seen = np.full(passes, 40)
    return SeenBefore(poses, stamps, seen, np.round(share * seen).astype(np.intp))


def followed(place: Array, seen: int, lying: int) -> Followed:
    counts = np.array([seen]), np.array([lying])
    return Followed(place[None], np.eye(3), np.eye(3), *counts, place, np.zeros((1, 3)))


@pytest.mark.parametrize("passes", [1, PASSES])
def test_a_place_is_as_known_as_the_robot_was_there_often(passes: int) -> None:
    here = followed(np.array([0.02, 0.0, 0.05]), 40, 40)
    assert before(passes).passes(here, 100.0) == passes


@pytest.mark.parametrize("place", [(0.3, 0.0, 0.0), (0.0, 0.0, 0.6)])
def test_elsewhere_or_with_another_heading_nothing_is_known(
    place: tuple[float, float, float],
) -> None:
    assert before(PASSES).passes(followed(np.array(place), 40, 40), 100.0) == 0


def test_the_pass_itself_does_not_make_its_place_known() -> None:
    assert before(1).passes(followed(np.zeros(3), 40, 40), 2.0) == 0


def test_new_tape_and_tape_that_is_gone_bring_something_new() -> None:
    assert before(PASSES).passes(followed(np.zeros(3), 40, 30), 100.0) == 0
    assert before(PASSES).passes(followed(np.zeros(3), 20, 20), 100.0) == 0


def test_what_never_lay_on_strokes_is_not_new() -> None:
    assert before(PASSES, share=0.5).passes(followed(np.zeros(3), 40, 20), 100.0) == PASSES


@pytest.mark.parametrize(
    ("aside", "turn", "pushed"), [(0.004, 0.023, False), (0.02, 0, True), (0, 0.1, True)]
)
def test_a_pose_that_wheels_do_not_lead_to_is_of_a_push(
    aside: float, turn: float, pushed: bool
) -> None:
    begin, step = np.array([1.0, 1.0, np.pi / 2]), np.array([0.02, 0.0, 0.0])
    pose = begin + np.array([aside, 0.02, turn])
    counts = np.array([40]), np.array([40])
    laid = Followed(pose[None], np.eye(3), np.eye(3), *counts, begin, step[None])
    assert laid.is_pushed is pushed


def test_a_bridge_leads_from_pose_to_pose() -> None:
    ends = np.array([[1.0, 1.0, np.pi / 2], [1.0, 1.5, -np.pi]])
    bridges = Bridges().and_one(7, ends, np.zeros((3, 3)))
    np.testing.assert_allclose(bridges.steps, [[0.5, 0.0, np.pi / 2]], atol=1e-12)
    assert bridges.before.tolist() == [7]


@pytest.mark.slow
@pytest.mark.timeout(240)
def test_laps_on_known_tape_are_laid_on_it_and_the_map_is_as_exact() -> None:
    log, _, poses = driven(
        "default", 9021, LAPS_S, map_name="square", calibrated=True, steer=Tour(SQUARE, 40)
    )
    mapper = Mapper(log, SPEC, WIDTH)
    drawn = mapper.run()
    used = poses[np.searchsorted(log.stamps, drawn.stamps)]
    errors = errors_of(drawn, used, SQUARE)
    assert errors.mean < 0.0003 and errors.path < 0.0003
    assert len(drawn.stamps) < 0.97 * len(mapper._every.stamps)
    assert drawn.fits and drawn.moved_at is None
