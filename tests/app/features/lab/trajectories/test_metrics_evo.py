"""Metrics agree with evo, a peer that is only imported here, and with published figures."""

from dataclasses import replace

import numpy as np
import pytest
from places import SHARED
from scipy.spatial.transform import Rotation
from wandering_paths import KINDS, moved, pair, relative_errors, rigid

from app.features.lab.trajectories.association import associate
from app.features.lab.trajectories.metrics import (
    absolute_errors,
    align,
    ate_rmse,
    fit_scale,
    heading_errors,
    rms,
)
from app.features.lab.trajectories.reading import read_trajectory
from app.trajectories.trajectory import Trajectory

RECORDED = SHARED / "tum_ate"
recorded = [
    pytest.mark.data,
    pytest.mark.skipif(not RECORDED.is_dir(), reason="needs the recorded trajectories"),
]


@pytest.fixture(scope="module")
def evo(tmp_path_factory):
    """The peer's modules; it writes its settings into the home at its first import."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HOME", str(tmp_path_factory.mktemp("home")))
        from evo.core import metrics, sync, trajectory, units
        from evo.tools.file_interface import read_tum_trajectory_file

    class Peer:
        pass

    Peer.metrics, Peer.sync, Peer.trajectory, Peer.unit = metrics, sync, trajectory, units.Unit
    Peer.read = staticmethod(read_tum_trajectory_file)
    return Peer


def as_evo(evo, trajectory):
    return evo.trajectory.PoseTrajectory3D(
        positions_xyz=np.array(trajectory.positions),
        orientations_quat_wxyz=trajectory.quaternions[:, [3, 0, 1, 2]],
        timestamps=np.array(trajectory.stamps),
    )


def evo_error(evo, metric, truth, estimate):
    metric.process_data((truth, estimate))
    return metric.error


def assert_agrees(evo, truth, estimate, atol=1e-9):
    """All metrics of pairs; angles of nothing differ by more, as their cosine is 1 - angle^2."""
    theirs, others = as_evo(evo, truth), as_evo(evo, estimate)
    relation = evo.metrics.PoseRelation
    ape = evo.metrics.APE(relation.translation_part)
    np.testing.assert_allclose(
        absolute_errors(truth, estimate), evo_error(evo, ape, theirs, others), atol=atol
    )
    angles = evo_error(evo, evo.metrics.APE(relation.rotation_angle_rad), theirs, others)
    np.testing.assert_allclose(np.abs(heading_errors(truth, estimate)), angles, atol=1e-7)
    for delta, unit, name in ((1, "frames", "frames"), (7, "frames", "frames"), (0.2, "m", "m")):
        found = relative_errors(truth, estimate, delta, unit)
        for part, which, tolerance in (
            (found[0], relation.translation_part, atol),
            (found[1], relation.rotation_angle_rad, 1e-7),
        ):
            rpe = evo.metrics.RPE(
                which,
                delta,
                getattr(evo.unit, {"m": "meters"}.get(name, name)),
                0.1,
                all_pairs=True,
                pairs_from_reference=True,
            )
            np.testing.assert_allclose(part, evo_error(evo, rpe, theirs, others), atol=tolerance)
    aligned = as_evo(evo, estimate)
    aligned.align(theirs)
    np.testing.assert_allclose(
        ate_rmse(truth, estimate, aligned=True),
        rms(evo_error(evo, evo.metrics.APE(relation.translation_part), theirs, aligned)),
        atol=atol,
    )


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(3))
def test_evo_agrees_on_random_paths(evo, kind, seed):
    truth, estimate, rng = pair(kind, seed)
    assert_agrees(evo, truth, estimate)
    assert_agrees(evo, truth, moved(estimate, rigid(kind, rng)))


@pytest.mark.parametrize("seed", range(20))
def test_evo_makes_the_same_pairs(evo, seed):
    """With many ties: stamps are multiples of 5 ms."""
    rng = np.random.default_rng(seed)

    def path(n, start):
        stamps = start + np.sort(rng.choice(2000, n, replace=False)) / 200
        return Trajectory.of_poses(stamps, rng.normal(size=(n, 3)))

    truth, estimate = path(rng.integers(400, 900), 0.0), path(rng.integers(400, 900), 3.0)
    both = as_evo(evo, truth), as_evo(evo, estimate)
    for largest in (0.003, 0.01, 0.03):
        ours = associate(truth, estimate, largest)
        theirs = evo.sync.associate_trajectories(*both, max_diff=largest)
        for mine, other in zip(ours, theirs, strict=True):
            np.testing.assert_array_equal(mine.positions, other.positions_xyz)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("scale", [0.1, 1.0, 3.0])
def test_evo_finds_the_same_scale(evo, kind, scale):
    truth, estimate, rng = pair(kind, 5)
    estimate = moved(estimate, rigid(kind, rng))
    estimate = replace(estimate, positions=estimate.positions / scale)
    fit, theirs = fit_scale(truth, estimate), as_evo(evo, estimate)
    _, _, factor = theirs.align(as_evo(evo, truth), correct_scale=True)
    assert fit.scale == pytest.approx(factor, rel=1e-9)
    ape = evo.metrics.APE(evo.metrics.PoseRelation.translation_part)
    errors = evo_error(evo, ape, as_evo(evo, truth), theirs)
    assert fit.scaled == pytest.approx(rms(errors), rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("who", ["truth", "estimate", "both"])
def test_evo_agrees_where_a_stamp_is_repeated(evo, tmp_path, who, seed):
    """As in the truth of TUM's freiburg2_desk; read from files, by each with its own reader."""
    rng = np.random.default_rng(seed)
    paths = []
    for name, count in (("truth", 600), ("estimate", 300)):
        steps = np.cumsum(rng.normal(0, 0.02, (count, 6)), axis=0)
        quaternions = Rotation.from_rotvec(steps[:, 3:]).as_quat()
        stamps = np.sort(rng.uniform(0, 20, count))
        if who in (name, "both"):
            for index in rng.choice(count - 1, 5, replace=False):
                stamps[index + 1] = stamps[index]
            stamps.sort()
        paths.append(tmp_path / f"{name}.txt")
        np.savetxt(paths[-1], np.column_stack([stamps, steps[:, :3], quaternions]), fmt="%.6f")
    ours = associate(*map(read_trajectory, paths), 0.05)
    theirs = evo.sync.associate_trajectories(*map(evo.read, map(str, paths)), max_diff=0.05)
    for mine, other in zip(ours, theirs, strict=True):
        np.testing.assert_array_equal(mine.positions, other.positions_xyz)
    assert_agrees(evo, *ours)


class TestRecorded:
    pytestmark = recorded

    def pairs(self, name):
        truth = read_trajectory(RECORDED / "freiburg1_xyz-groundtruth.txt")
        return associate(truth, read_trajectory(RECORDED / f"freiburg1_xyz-{name}.txt"))

    def test_freiburg_has_the_published_figures(self):
        truth, estimate = self.pairs("rgbdslam")
        assert len(truth) == 785
        errors = absolute_errors(truth, align(truth, estimate).apply(estimate))
        assert ate_rmse(truth, estimate) == pytest.approx(0.020079, abs=5e-7)
        assert rms(errors) == pytest.approx(0.013470, abs=5e-7)
        assert errors.mean() == pytest.approx(0.012024, abs=5e-7)
        assert errors.max() == pytest.approx(0.034760, abs=5e-7)
        for frames, figure in ((1, 0.005764), (30, 0.021701)):
            translation, _ = relative_errors(truth, estimate, frames, "frames")
            assert rms(translation) == pytest.approx(figure, abs=5e-7)

    @pytest.mark.slow
    @pytest.mark.parametrize("name", ["rgbdslam", "rgbdslam_drift"])
    def test_evo_agrees(self, evo, name):
        assert_agrees(evo, *self.pairs(name))
