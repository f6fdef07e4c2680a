"""Places are weighed by scans, kept while they may be right, and given up when they are not."""

from __future__ import annotations

import math

import numpy as np
import pytest
from square_drive import NARROW, ON_SQUARE, ON_STUB, SQUARE, drive_on, right, setup_of
from stub_drive import DEFAULTS, Drive
from told_filters import at_places

from robot.geometry import Pose2
from robot.localization.hypotheses.multi_hypothesis import (
    LEAST_SHARE,
    PRIOR_MAP_LENGTHS,
    MultiHypothesisFilter,
)
from robot.localization.hypotheses.start_poses import log_prior
from robot.localization.hypotheses.track import INDIFFERENT, STEADY, Track
from robot.scan import rays_of


def poses(f: MultiHypothesisFilter) -> list[Pose2]:
    return [one.pose for one in f.hypotheses]


ELSEWHERE = Pose2(-0.2, 0.1, 2.0)


def test_weights_are_shares_heaviest_first_and_leave_room_for_elsewhere() -> None:
    f = at_places((Pose2(), -1.0), (ELSEWHERE, 0.0))
    heavy, light = f.hypotheses
    assert heavy.pose == ELSEWHERE
    assert light.weight / heavy.weight == pytest.approx(math.exp(-1))
    gone = DEFAULTS.hypotheses.kidnapped
    assert heavy.weight + light.weight == pytest.approx(1 - gone / (1 + math.exp(-1)), rel=1e-4)


def test_a_place_with_several_hypotheses_shares_its_weight_among_them() -> None:
    f = at_places((Pose2(), 0.0), (ELSEWHERE, math.log(0.5)))
    f._tracks[0].filter.weights = (0.4, 0.3)  # type: ignore[attr-defined]
    weights = [one.weight for one in f.hypotheses]
    assert weights == pytest.approx([1 / 3, 0.4 * 2 / 3, 0.3 * 2 / 3], rel=1e-3)


def test_the_cloud_is_that_of_all_places_by_their_weights() -> None:
    f = at_places((Pose2(), 0.0), (ELSEWHERE, math.log(0.25)))
    np.testing.assert_allclose(f.cloud.weights, [0.2] * 4 + [0.05] * 4)
    np.testing.assert_array_equal(f.cloud.poses[4], ELSEWHERE.to_array())
    assert f.effective == pytest.approx(1 / (4 * 0.2**2 + 4 * 0.05**2))


def test_a_place_that_does_not_fit_is_given_up_but_not_for_one_scan() -> None:
    f, drive = at_places((Pose2(), 0.0), (ELSEWHERE, 0.0)), Drive()
    f.correct(drive.scan())
    _, light = f.hypotheses
    assert light.pose == ELSEWHERE
    assert light.weight / f.hypotheses[0].weight == pytest.approx(math.exp(-STEADY))
    for _ in range(6):
        f.predict(Pose2(0.01))
        drive.true = drive.true @ Pose2(0.01)
        f.correct(drive.scan())
    assert len(f.hypotheses) == 1
    assert right(f.hypotheses[0], drive)


def test_a_place_that_looks_worse_for_a_while_may_win_later() -> None:
    """It starts far lighter; scans tell for it."""
    f, drive = at_places((Pose2(), -8.0), (ELSEWHERE, 0.0)), Drive()
    for _ in range(6):
        f.correct(drive.scan())
        f.predict(Pose2(0.01))
        drive.true = drive.true @ Pose2(0.01)
    assert right(f.hypotheses[0], drive) and f.hypotheses[0].weight > 0.9


def test_the_hopelessly_light_one_is_given_up_at_once() -> None:
    limit = DEFAULTS.hypotheses.log_hopeless
    for weight, kept in ((limit + 0.1, True), (limit - 0.1, False)):
        turned = Pose2(0, 0, math.pi / 2)
        start = Pose2(0.05, 0.1, 0.5)
        f = at_places((start, 0.0), (turned @ start, weight), setup=ON_SQUARE)
        f.correct(drive_on(SQUARE, start).scan())
        assert (len(f.hypotheses) == 2) == kept


def test_places_that_come_together_are_one_and_the_heavier_stays() -> None:
    heavy, light = Pose2(0.004, 0, 0), Pose2(0, 0.004, 0.01)
    f = at_places((light, -0.5), (heavy, 0.0), (ELSEWHERE, 0.0))
    f.correct(Drive().scan())
    assert set(poses(f)) == {heavy, ELSEWHERE}


def test_places_that_differ_in_heading_alone_are_two() -> None:
    f = at_places((Pose2(), 0.0), (Pose2(0, 0, 0.3), 0.0))
    f.correct(Drive().scan())
    assert len(f.hypotheses) == 2


def test_no_more_are_followed_than_may_be_and_the_lightest_go() -> None:
    start = Pose2(0.05, 0.1, 0.5)
    places = [(Pose2(0, 0, n * math.pi / 2) @ start, -0.1 * n) for n in range(4)]
    setup = setup_of(SQUARE, ON_SQUARE.entries, max_hypotheses=2)
    f = at_places(*reversed(places), setup=setup)
    f.correct(drive_on(SQUARE, start).scan())
    assert poses(f) == [pose for pose, _ in places[:2]]


def test_particles_are_shared_by_weight_but_none_has_too_few() -> None:
    start = Pose2(0.05, 0.1, 0.5)
    places = [
        (Pose2(0, 0, n * math.pi / 2) @ start, weight) for n, weight in enumerate([0.0, -1.0, -4.0])
    ]
    f = at_places(*places, setup=ON_SQUARE)
    f.correct(drive_on(SQUARE, start).scan())
    shares = [track.filter.share for track in f._tracks]
    assert shares == pytest.approx(
        [*(one.weight for one in f.hypotheses[:2]), LEAST_SHARE], abs=1e-3
    )


@pytest.mark.parametrize(("share", "counts"), [(0.9, False), (1.1, True)])
def test_a_difference_of_less_than_a_ray_does_not_count_however_often(
    share: float, counts: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    lower = share * INDIFFERENT / DEFAULTS.hypotheses.scan_worth
    fits = {Pose2(): 3.0, ELSEWHERE: 3.0 - lower}
    monkeypatch.setattr(Track, "fit", lambda track, *_: fits[track.pose])
    f = at_places((Pose2(), 0.0), (ELSEWHERE, 0.0))
    for _ in range(5):
        f._weigh(rays_of(Drive().scan(), 60))
    heavy, light = f.hypotheses
    wanted = math.exp(-5 * share * INDIFFERENT) if counts else 1.0
    assert light.weight / heavy.weight == pytest.approx(wanted)


def test_small_differences_between_places_do_not_add_up() -> None:
    """On a square, with places a little off as a particle filter has them."""
    rng, start = np.random.default_rng(0), Pose2(0.05, 0.1, 0.5)
    drive = drive_on(SQUARE, start)
    f = at_places(*((Pose2(0, 0, n * math.pi / 2) @ start, 0.0) for n in range(4)), setup=ON_SQUARE)
    for _ in range(60):
        f.predict(Pose2(0.01, 0, 0.06))
        drive.true = drive.true @ Pose2(0.01, 0, 0.06)
        for n, track in enumerate(f._tracks):
            off = rng.normal(0, [0.001, 0.001, 0.004])
            track.filter.set_pose(
                Pose2(0, 0, n * math.pi / 2) @ drive.true @ Pose2.from_array(off), NARROW
            )
        f.correct(drive.scan())
    weights = [track.log_weight for track in f._tracks]
    assert len(weights) >= 4 and np.ptp(weights[:4]) < math.log(2)


def test_scans_and_setups_reach_every_place() -> None:
    f = at_places((Pose2(), 0.0), (ELSEWHERE, 0.0))
    fixed = [track.filter for track in f._tracks]
    scan = Drive().scan()
    f.correct(scan)
    f.use(ON_STUB)
    assert [one.told for one in fixed] == [[scan, ON_STUB]] * 2  # type: ignore[attr-defined]


def test_what_was_told_of_the_start_moves_with_odometry() -> None:
    """A place found later is as likely as the start it would have come from."""
    f = at_places((Pose2(), 0.0))
    step = Pose2(0.2, 0.1, 0.5)
    f.predict(step)
    log_kidnapped = f.setup.hypotheses.log_kidnapped
    assert log_prior(f._priors, step, log_kidnapped) == pytest.approx(0, abs=1e-3)
    assert log_prior(f._priors, step @ step, log_kidnapped) < -4


def test_what_was_told_of_the_start_counts_no_more_when_it_is_long_ago() -> None:
    """What was seen since then says more, and a place found now has not been held against it."""
    f = at_places((Pose2(), 0.0))
    f._scans = PRIOR_MAP_LENGTHS * DEFAULTS.hypotheses.map_scans - 1
    drive = Drive()
    f._searches.add(drive.scan())
    for moved, scan in drive.eight(0.2):
        f.predict(moved)
        f.correct(scan)
    assert (
        log_prior(f._priors, f._tracks[0].pose, f.setup.hypotheses.log_kidnapped)
        == DEFAULTS.hypotheses.log_kidnapped
    )
