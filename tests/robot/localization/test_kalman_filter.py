"""The Kalman filter is exact where the textbook is, and breaks on nothing."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from stub_drive import BEARINGS, DEFAULTS, PERIOD, STUB, Drive, draw_poses, matcher_of, noisy_scan

from robot.fields.edges import outline
from robot.fields.field import Field
from robot.geometry import Array, Pose2, Twist2, wrap_angle
from robot.localization.estimate import Hypothesis
from robot.localization.filter import Cloud
from robot.localization.kalman_filter import KalmanFilter
from robot.localization.models.motion_models import DifferentialMotion, MotionModel
from robot.scan import Scan

MOTION = DEFAULTS.motion.model()
EXACT = DifferentialMotion(0, 0, 0, 0)
WALL = replace(STUB, edges=outline(shapely.box(0.5, -9, 0.55, 9)))
"""One straight piece of tape across x: it says nothing of y."""
SD = 0.003
STEP = Twist2(0.15, 0.79).integrate(PERIOD)


def filter_of(
    field: Field = STUB,
    sd: float = SD,
    motion: MotionModel = MOTION,
    seed: int = 0,
    doubt: float = 0,
) -> KalmanFilter:
    rng = np.random.default_rng(seed)
    return KalmanFilter(motion, matcher_of(field, sd), field, np.eye(3), 61, rng, doubt=doubt)


def covariance(f: KalmanFilter) -> Array:
    return f.hypotheses[0].covariance


def pose(f: KalmanFilter) -> Pose2:
    return f.hypotheses[0].pose


poses = st.builds(Pose2, st.floats(-1, 1), st.floats(-1, 1), st.floats(-3.14, 3.14))
roots = arrays(float, (3, 3), elements=st.floats(-0.3, 0.3))


# --- correction


def ahead(distance: float) -> Scan:
    """One ray, straight ahead."""
    return Scan(0.0, np.zeros(1), np.array([distance]))


def test_one_ray_at_right_angles_is_the_linear_filter() -> None:
    """There z = 0.5 - x, so K = -P / (P + sd^2) (Table 3.1); y and theta are not measured.

    What surprises pulls less (Cauchy): a small innovation counts in full.
    """
    f = filter_of(WALL)
    prior = np.diag([0.01**2, 0.02**2, 0.05**2])
    f.set_pose(Pose2(0.1, 0.2, 0.0), prior)
    f.correct(ahead(0.3999))
    gain = 0.01**2 / (0.01**2 + SD**2)
    assert pose(f).x == pytest.approx(0.1 + gain * 0.0001, abs=1e-8)
    assert pose(f).y == pytest.approx(0.2, abs=1e-9)
    assert pose(f).theta == pytest.approx(0.0, abs=1e-9)
    posterior = np.diag([(1 - gain) * 0.01**2, 0.02**2, 0.05**2])
    np.testing.assert_allclose(covariance(f), posterior, rtol=1e-5, atol=1e-12)


def test_a_ray_measures_also_what_hangs_together_with_its_range() -> None:
    """Cross-covariance moves y along with x: K = Sigma H^T / (H Sigma H^T + sd^2)."""
    f = filter_of(WALL)
    prior = np.array([[4e-4, 2e-4, 0], [2e-4, 3e-4, 0], [0, 0, 1e-8]])
    f.set_pose(Pose2(0.1, 0.2, 0.0), prior)
    f.correct(ahead(0.3999))
    gain = prior[:, 0] / (prior[0, 0] + SD**2)
    np.testing.assert_allclose(pose(f).to_array(), [0.1, 0.2, 0] + gain * 0.0001, atol=1e-8)
    expected = prior - np.outer(gain, prior[0])
    np.testing.assert_allclose(covariance(f), expected, rtol=1e-4, atol=1e-9)


def test_what_two_scans_say_adds_up() -> None:
    """n equal measurements: 1 / (1 / P + n / sd^2)."""
    f = filter_of(WALL)
    f.set_pose(Pose2(0.1, 0.2, 0.0), np.diag([0.01**2, 0.02**2, 1e-10]))
    for n in range(1, 6):
        f.correct(ahead(0.4))
        assert covariance(f)[0, 0] == pytest.approx(1 / (1 / 0.01**2 + n / SD**2), rel=1e-5)


def test_nothing_is_learnt_along_a_wall() -> None:
    f = filter_of(WALL)
    f.set_pose(Pose2(0.1, 0.2, 0.0), np.diag(np.square([0.02, 0.02, 0.05])))
    ranges = 0.4 / np.cos(BEARINGS)
    for _ in range(50):
        f.correct(Scan(0.0, BEARINGS, ranges))
    x, y, theta = np.sqrt(np.diag(covariance(f)))
    assert x < 0.001 and theta < 0.002
    assert y == pytest.approx(0.02, rel=1e-3)
    assert pose(f).y == pytest.approx(0.2, abs=1e-4)


@pytest.mark.parametrize(
    "scan",
    [
        Scan(0.0, np.zeros(0), np.zeros(0)),
        Scan(0.0, BEARINGS, np.full(61, np.inf)),
        Scan(0.0, BEARINGS, np.full(61, 0.02)),
        Scan(0.0, BEARINGS, np.full(61, 0.4), sight=np.full((61, 2), np.nan)),
    ],
    ids=["empty", "no returns", "of something else", "out of sight"],
)
def test_a_scan_without_a_ray_that_fits_leaves_the_prediction(scan: Scan) -> None:
    f = filter_of()
    f.set_pose(Pose2(0.1, 0.05, 0.3), np.diag([1e-4, 2e-4, 3e-4]))
    f.predict(STEP)
    before = f.hypotheses[0]
    f.correct(scan)
    after = f.hypotheses[0]
    assert after.pose == before.pose
    np.testing.assert_array_equal(after.covariance, before.covariance)


def test_an_outlier_does_not_pull() -> None:
    f, drive = filter_of(), Drive()
    scan = drive.scan()
    ranges = scan.ranges.copy()
    ranges[::3] -= 0.1
    f.set_pose(Pose2(0.003, 0.002, 0.01), np.diag(np.square([0.01, 0.01, 0.02])))
    f.correct(replace(scan, ranges=ranges))
    # One wall is in sight: it says x and heading.
    assert abs(pose(f).x) < 0.001 and abs(pose(f).theta) < 0.003


# --- certainty and doubt


@pytest.mark.parametrize(
    "known",
    [
        np.zeros((3, 3)),
        np.diag([0.0, 1e-4, 1e-4]),
        np.diag([1e-4, 1e-4, 0.0]),
        np.outer([0.01, 0.02, 0.03], [0.01, 0.02, 0.03]),
        np.full((3, 3), 1e-300),
    ],
    ids=["all", "x", "heading", "of rank one", "underflow"],
)
def test_a_covariance_without_an_inverse_is_no_trouble(known: Array) -> None:
    f, drive = filter_of(), Drive()
    f.set_pose(drive.true, known)
    f.correct(drive.scan())
    assert (np.diag(covariance(f)) <= np.diag(known) + 1e-11).all()
    assert pose(f).distance_to(drive.true) < 0.002
    assert np.linalg.eigvalsh(covariance(f))[0] >= 0


def test_certain_it_stays_whatever_a_scan_says() -> None:
    f = filter_of(WALL)
    f.set_pose(Pose2(0.1, 0.2, 0.0), np.zeros((3, 3)))
    f.correct(ahead(0.38))
    assert pose(f).distance_to(Pose2(0.1, 0.2)) < 1e-7


@given(poses, roots, st.lists(st.sampled_from([Pose2(), STEP, Pose2(-0.1, 0, 2)]), max_size=4))
def test_its_covariance_is_one_always(start: Pose2, root: Array, steps: list[Pose2]) -> None:
    f, drive = filter_of(), Drive()
    f.set_pose(start, root @ root.T)
    for moved in steps:
        f.predict(moved)
        before = covariance(f)
        f.correct(drive.scan())
        after = covariance(f)
        np.testing.assert_array_equal(after, after.T)
        assert np.linalg.eigvalsh(after)[0] >= -1e-12
        # A scan takes no knowledge away.
        assert np.linalg.eigvalsh(before - after)[0] >= -1e-6 * max(1.0, before.max())
        assert pose(f).is_finite()


def test_without_noise_it_stays_on_the_truth() -> None:
    f, drive = filter_of(motion=EXACT), Drive()
    f.set_pose(drive.true, np.diag(np.square([0.01, 0.01, 0.02])))
    for _ in range(120):
        drive.step(Twist2(0.15, 0.79))
        f.predict(STEP)
        f.correct(noisy_scan(drive.true, 0.0, np.random.default_rng(0)))
        assert pose(f).distance_to(drive.true) < 1e-6
        assert abs(pose(f).turn_to(drive.true)) < 1e-6


@pytest.mark.slow
def test_its_errors_are_as_large_as_it_claims() -> None:
    """Mean of e^T Sigma^-1 e over 60 drives (NEES): chi-squared with 180 degrees, 99.9 %."""
    squared = []
    told, sds = Pose2(), (0.01, 0.01, 0.02)
    for seed in range(60):
        rng = np.random.default_rng(seed)
        f, true = filter_of(seed=seed), draw_poses(rng, told, sds, 1)
        f.set_pose(told, np.diag(np.square(sds)))
        for _ in range(20):
            true = MOTION.sample(true, STEP, rng)
            f.predict(STEP)
            f.correct(noisy_scan(Pose2(*true[0].tolist()), SD, rng))
        error = pose(f).to_array() - true[0]
        squared.append(error @ np.linalg.solve(covariance(f), error))
    low, high = 126.1 / 60, 246.4 / 60
    assert low < np.mean(squared) < high


@pytest.mark.parametrize("seed", range(3))
def test_it_follows_a_robot_with_erring_odometry_to_a_millimetre(seed: int) -> None:
    f, drive = filter_of(sd=0.02), Drive(rng=np.random.default_rng(seed))
    f.set_pose(Pose2(0.02, 0.01, 0.05), np.diag(np.square([0.03, 0.03, 0.1])))
    errors = []
    for moved, scan in drive.eight(6.0):
        f.predict(moved)
        f.correct(scan)
        errors.append((pose(f).distance_to(drive.true), abs(pose(f).turn_to(drive.true))))
    late = np.array(errors[45:])
    assert np.sqrt(np.mean(late[:, 0] ** 2)) < 0.001
    assert np.sqrt(np.mean(late[:, 1] ** 2)) < 0.005


def test_told_ten_centimetres_wrong_it_stays_sound_though_it_may_be_lost() -> None:
    """Rays beyond the gate say nothing; whether it finds back is luck, and it cannot tell."""
    f, drive = filter_of(sd=0.02), Drive()
    f.set_pose(Pose2(-0.1, -0.1, 0.3), np.diag(np.square([0.01, 0.01, 0.02])))
    for moved, scan in drive.eight(4.0):
        f.predict(moved)
        f.correct(scan)
    assert pose(f).is_finite() and STUB.contains(pose(f))
    assert [hypothesis.weight for hypothesis in f.hypotheses] == [1.0]
    assert np.linalg.eigvalsh(covariance(f))[0] > 0


@pytest.mark.slow
def test_in_doubt_it_believes_ranges_less_and_lets_more_of_them_in() -> None:
    """Told wrong by more than the gate it finds back at once; where it is sure nothing changes."""
    textbook, cautious = filter_of(sd=0.0067), filter_of(sd=0.0067, doubt=1.0)
    wide, found = np.diag(np.square([0.1, 0.1, 0.3])), []
    for f in (textbook, cautious):
        rng, right = np.random.default_rng(6), 0
        for seed in range(40):
            start = Pose2(*rng.uniform(-0.1, 0.1, 2), rng.uniform(-3, 3))
            drive = Drive(start, rng=np.random.default_rng(seed))
            way, turn = rng.uniform(-3, 3), rng.choice([-0.2, 0.2])
            x, y = drive.true.x + 0.07 * math.cos(way), drive.true.y + 0.07 * math.sin(way)
            f.set_pose(Pose2(x, y, drive.true.theta + turn), wide)
            for moved, scan in drive.eight(1.0):
                f.predict(moved)
                f.correct(scan)
            right += pose(f).distance_to(drive.true) < 0.005
        found.append(right)
    assert found[1] >= 37 and found[0] <= found[1] - 4
    sure = np.diag(np.square([1e-5, 1e-5, 1e-5]))
    for f in (textbook, cautious):
        f.set_pose(Pose2(0.001, 0, 0), sure)
        f.correct(Drive().scan())
    assert pose(textbook).distance_to(pose(cautious)) < 1e-7
    np.testing.assert_allclose(covariance(cautious), covariance(textbook), rtol=1e-3, atol=1e-16)


# --- what is shown and given


@given(poses, roots)
def test_its_cloud_has_its_mean_and_covariance(start: Pose2, root: Array) -> None:
    f = filter_of()
    f.set_pose(start, 0.1 * root @ root.T)
    cloud = f.cloud
    offsets = cloud.poses - start.to_array()
    offsets[:, 2] = wrap_angle(offsets[:, 2])
    np.testing.assert_allclose(offsets.mean(axis=0), 0, atol=1e-9)
    np.testing.assert_allclose(np.cov(offsets.T, bias=True), covariance(f), atol=1e-9)


def test_from_a_cloud_it_takes_mean_and_covariance() -> None:
    f = filter_of()
    given_poses = np.array([[0.1, 0, 3.1], [0.3, 0, -3.1]])
    f.set_cloud(Cloud(given_poses, np.array([0.75, 0.25])))
    assert (pose(f).x, pose(f).y) == pytest.approx((0.15, 0))
    assert covariance(f)[0, 0] == pytest.approx(0.75 * 0.05**2 + 0.25 * 0.15**2)


def test_from_several_places_it_is_as_wide_as_they_are_and_lie_apart() -> None:
    f = filter_of()
    narrow = np.diag(np.square([0.01, 0.02, 0.03]))
    f.set_hypotheses((Hypothesis(0.3, Pose2(0.1), narrow), Hypothesis(0.1, Pose2(0.5), 5 * narrow)))
    assert pose(f).x == pytest.approx(0.2)
    within = (0.75 + 0.25 * 5) * narrow
    between = 0.75 * 0.1**2 + 0.25 * 0.3**2
    np.testing.assert_allclose(covariance(f), within + np.diag([between, 0, 0]), atol=1e-12)


def test_scattered_it_is_as_wide_as_the_field() -> None:
    f = filter_of()
    f.scatter()
    *position, theta = np.sqrt(covariance(f).diagonal())
    np.testing.assert_allclose(position, 0.95 / math.sqrt(12), rtol=0.08)
    assert theta > 1.5
