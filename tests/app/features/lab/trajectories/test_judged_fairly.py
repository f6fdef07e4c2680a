"""The judge: a clock is corrected only if it is off, and nothing is left out without a word."""

import json

import numpy as np
import pytest
from recorded_runs import eight, evaluate, mean
from rosbags.rosbag2 import Writer
from rosbags.typesys import Stores, get_typestore

from app.command_line import main
from app.features.lab.evaluation.recorded_words import _asked
from app.features.lab.trajectories.association import pairs_of
from app.features.lab.trajectories.clock_offset import estimate_clock_offset, require_same_run
from app.features.lab.trajectories.reading import read_trajectory
from app.trajectories.trajectory import Trajectory, TrajectoryError
from app.trajectories.tum_file import write_tum
from benchmarks.clock_offsets import clean_pair, faulty_pair, judged

LAP = 25.0


def rounds(stamps, lap=LAP):
    """A lap of uneven bends at each time (n, 3)."""
    phase = 2 * np.pi * np.asarray(stamps) / lap
    x = np.cos(phase) + 0.3 * np.cos(2 * phase)
    y = np.sin(phase) - 0.2 * np.sin(3 * phase)
    ahead = np.stack(
        [-np.sin(phase) - 0.6 * np.sin(2 * phase), np.cos(phase) - 0.6 * np.cos(3 * phase)]
    )
    return np.column_stack([x, y, np.arctan2(ahead[1], ahead[0])])


def laps(first, last, rate, noise=0.0, seed=0, shift=0.0):
    stamps = np.arange(first, last, 1 / rate)
    poses = rounds(stamps)
    poses[:, :2] += np.random.default_rng(seed).normal(0, noise, (len(stamps), 2))
    return Trajectory.of_poses(stamps + shift, poses)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [100, 101, 102, 103, 104, 105, 106, 107])
def test_noise_of_20_mm_makes_no_offset(seed):
    """The correlation alone was off by 14 to 56 ms, which was then corrected."""
    rng = np.random.default_rng(seed)
    truth = laps(0, 120, 20)
    stamps = np.arange(0.05, 20, 0.1)
    poses = rounds(stamps) + rng.normal(0, 1, (200, 3)) * (0.02, 0.02, 0.005)
    clock = require_same_run(truth, Trajectory.of_poses(stamps, poses))
    assert clock.correction == 0
    assert abs(clock.seconds) < 3 * clock.shift.deviation < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("begin", [0.0, 0.03, 0.05, 7.77])
def test_without_noise_it_does_not_matter_when_a_file_begins(begin):
    clock = require_same_run(laps(0, 120, 20), laps(begin, begin + 20, 10))
    assert clock.seconds == pytest.approx(0, abs=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("fault", ["scattered", "frozen", "zero"])
def test_a_robot_that_was_lost_is_not_compared_with_the_next_lap(tmp_path, capsys, fault):
    truth, estimate = laps(0, 50, 20), laps(0, 50, 10, noise=0.003)
    poses, rng = estimate.poses, np.random.default_rng(0)
    poses[:60] = {
        "scattered": poses[:60] + rng.normal(0, 0.2, (60, 3)),
        "frozen": np.tile(poses[0], (60, 1)),
        "zero": np.zeros((60, 3)),
    }[fault]
    write_tum(tmp_path / "truth.tum", truth)
    write_tum(tmp_path / "estimate.tum", Trajectory.of_poses(estimate.stamps, poses))
    code, results = evaluate(tmp_path, "--truth", str(tmp_path / "truth.tum"))
    assert code == 0
    right = np.sqrt(np.mean(np.sum((poses - rounds(estimate.stamps))[:, :2] ** 2, axis=1)))
    assert mean(results) == pytest.approx(right, rel=1e-3)
    assert results["experiment"]["poses"] == 500
    assert results["experiment"]["clock_offset_added_s"] == 0
    assert "on 500 pairs of poses, which cover 49.9 of the recording's 49.9 s (100%)" in (
        capsys.readouterr().out
    )


def test_one_bad_pose_moves_no_clock():
    estimate = laps(0.025, 60, 10, noise=0.003)
    poses = estimate.poses
    poses[300] += (8.0, 8.0, 1.0)
    clock = require_same_run(laps(0, 60, 20), Trajectory.of_poses(estimate.stamps, poses))
    assert clock.correction == 0


@pytest.mark.slow
@pytest.mark.parametrize("offset", [0.04, -0.3, 3.2])
def test_a_clock_that_is_off_is_corrected_with_an_interval(tmp_path, capsys, offset):
    write_tum(tmp_path / "truth.tum", laps(0, 60, 50))
    write_tum(tmp_path / "estimate.tum", laps(5, 55, 20, noise=0.005, shift=-offset))
    code, results = evaluate(tmp_path, "--truth", str(tmp_path / "truth.tum"))
    assert code == 0
    said, found = capsys.readouterr().out, results["experiment"]
    assert found["clock_offset_added_s"] == pytest.approx(
        offset, abs=4 * found["clock_offset_sd_s"]
    )
    low, high = found["clock_offset_interval_s"]
    assert low < found["clock_offset_added_s"] < high
    assert f"(95 %: {low:.4f} to {high:.4f} s to add)" in said
    assert mean(results) == pytest.approx(0.005 * np.sqrt(2), rel=0.1)
    # What the figure would be without it is told, too.
    assert found["without_it"]["ate_rmse_m"] > mean(results)
    assert "without that: unaligned" in said
    report = (tmp_path / "out" / "report.html").read_text()
    assert f"{low:.4f} to {high:.4f}" in report


class TestALap:
    """One lap of an estimate whose clock is off, in a truth of five."""

    def files(self, tmp_path, shift):
        write_tum(tmp_path / "truth.tum", laps(0, 125, 20))
        write_tum(tmp_path / "estimate.tum", laps(50, 75, 20, noise=0.005, shift=shift))
        return "--truth", str(tmp_path / "truth.tum")

    @pytest.mark.slow
    def test_which_one_is_asked_and_stamps_are_left(self, tmp_path, capsys):
        code, results = evaluate(tmp_path, *self.files(tmp_path, 10.0))
        assert code == 0
        experiment, said = results["experiment"], capsys.readouterr().out
        assert experiment["clock_offset_added_s"] == 0
        assert "off by a lap?" in said
        assert mean(results) > 0.5
        for lap in (-60, -35, -10, 15, 40):
            assert any(abs(float(c) - lap) < 0.05 for c in experiment["clock_offset_choices"])
        assert "--clock-offset 0 or " in said

    def test_the_option_decides(self, tmp_path):
        files = self.files(tmp_path, 10.0)
        code, results = evaluate(tmp_path, *files, "--clock-offset", "-10")
        assert code == 0
        assert mean(results) < 0.01

    def test_clocks_that_agree_need_no_question(self, tmp_path, capsys):
        code, results = evaluate(tmp_path, *self.files(tmp_path, 0.0))
        assert code == 0
        assert "lap" not in capsys.readouterr().out
        assert mean(results) < 0.01

    def test_of_other_clocks_it_is_refused_with_the_choices(self, tmp_path, capsys):
        assert evaluate(tmp_path, *self.files(tmp_path, 1e6))[0] == 2
        error = capsys.readouterr().err
        assert "which lap is it?" in error
        assert "--clock-offset" in error

    def test_who_sits_there_is_asked(self, tmp_path, capsys, monkeypatch):
        self.files(tmp_path, 10.0)
        clock = estimate_clock_offset(*(
            read_trajectory(tmp_path / name) for name in ("truth.tum", "estimate.tum")
        ))  # fmt: skip
        answers = iter(
            [
                "9",
                str(1 + clock.choices.index(min(clock.choices, key=lambda c: abs(float(c) + 10)))),
            ]
        )
        monkeypatch.setattr("sys.stdin.readline", lambda: next(answers) + "\n", raising=False)
        assert _asked(clock) == pytest.approx(-10, abs=0.05)
        assert "'9' is none of them" in capsys.readouterr().out


class TestTruthWithAPoseASecond:
    def files(self, tmp_path, noise=0.0):
        write_tum(tmp_path / "truth.tum", laps(0, 100, 1))
        write_tum(tmp_path / "estimate.tum", laps(0.05, 100, 10, noise=noise))
        return "--truth", str(tmp_path / "truth.tum")

    @pytest.mark.slow
    @pytest.mark.parametrize("noise", [0.0, 0.02])
    def test_is_interpolated_and_told(self, tmp_path, capsys, noise):
        code, results = evaluate(tmp_path, *self.files(tmp_path, noise))
        assert code == 0
        assert mean(results) == pytest.approx(noise * np.sqrt(2), rel=0.05, abs=0.0005)
        assert results["experiment"]["poses"] == 990
        # Headings at the sharpest bends of this path: its curvature doubles within a second.
        assert mean(results, "heading_rmse_rad") < 0.02
        assert "the truth is interpolated, which errs by up to about" in capsys.readouterr().out

    @pytest.mark.slow
    def test_is_paired_by_a_given_difference(self, tmp_path, capsys):
        files = self.files(tmp_path)
        code, results = evaluate(tmp_path, *files, "--max-time-difference", "0.06")
        assert code == 0
        assert results["experiment"]["poses"] == 100
        assert results["experiment"]["interpolation_error_m"] is None
        assert "on 100 pairs of poses" in capsys.readouterr().out
        assert evaluate(tmp_path, *files, "--max-time-difference", "0.01")[0] == 2
        assert "no pairs of poses at one time, within 0.01 s" in capsys.readouterr().err
        assert evaluate(tmp_path, *files, "--max-time-difference", "-1")[0] == 2
        assert "valid is a positive number" in capsys.readouterr().err

    def test_stamps_that_meet_are_paired_as_evo_does(self):
        pairs = pairs_of(laps(0, 50, 100), laps(0.004, 50, 10))
        assert pairs.interpolation_error is None
        assert len(pairs) == 500


@pytest.mark.slow
@pytest.mark.parametrize(("unit", "of_a_second"), [("nano", 1e9), ("micro", 1e6), ("milli", 1e3)])
def test_stamps_in_another_unit_are_understood_and_told(tmp_path, capsys, unit, of_a_second):
    write_tum(tmp_path / "truth.tum", laps(0, 50, 20, shift=1.7e9))
    estimate = laps(0, 50, 10, noise=0.005, shift=1.7e9)
    table = np.column_stack(
        [estimate.stamps * of_a_second, estimate.positions, estimate.quaternions]
    )
    np.savetxt(tmp_path / "estimate.tum", table, fmt=["%.0f"] + ["%.9f"] * 7)
    code, results = evaluate(tmp_path, "--truth", str(tmp_path / "truth.tum"))
    assert code == 0
    assert mean(results) == pytest.approx(0.005 * np.sqrt(2), rel=0.1)
    assert f"are {unit}seconds" in capsys.readouterr().out


class TestKitti:
    def write(self, path, trajectory):
        theta = trajectory.poses[:, 2]
        c, s, o, i = np.cos(theta), np.sin(theta), 0 * theta, 1 + 0 * theta
        x, y = trajectory.positions[:, :2].T
        np.savetxt(path, np.column_stack([c, -s, o, x, s, c, o, y, o, o, i, o]))

    def test_poses_are_paired_by_their_number(self, tmp_path, capsys):
        self.write(tmp_path / "truth.tum", laps(0, 50, 10))
        self.write(tmp_path / "estimate.tum", laps(0, 50, 10, noise=0.01))
        code, results = evaluate(tmp_path, "--truth", str(tmp_path / "truth.tum"))
        assert code == 0
        assert results["experiment"]["poses"] == 500
        assert mean(results) == pytest.approx(0.01 * np.sqrt(2), rel=0.1)
        assert (
            "has no stamps (times.txt beside it would): a pose each 0.1 s"
            in capsys.readouterr().out
        )

    def test_stamps_are_read_beside_them(self, tmp_path):
        (tmp_path / "kitti").mkdir()
        truth = laps(0, 50, 20, shift=100.0)
        self.write(tmp_path / "kitti" / "00.txt", truth)
        np.savetxt(tmp_path / "kitti" / "times.txt", truth.stamps)
        np.testing.assert_allclose(
            read_trajectory(tmp_path / "kitti" / "00.txt").stamps, truth.stamps
        )
        np.savetxt(tmp_path / "kitti" / "times.txt", truth.stamps[1:])
        with pytest.raises(TrajectoryError, match=r"1000 poses, and times.txt 999"):
            read_trajectory(tmp_path / "kitti" / "00.txt")

    def test_what_is_no_rotation_is_refused_by_line(self, tmp_path):
        (tmp_path / "a.txt").write_text("1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 5 0\n")
        with pytest.raises(TrajectoryError, match=r"a.txt, line 2: no rotation"):
            read_trajectory(tmp_path / "a.txt")


class TestBag:
    @pytest.fixture
    def bag(self, tmp_path):
        """Odometry, one message of it absurd; and the same as map - odom - base_link."""
        store = get_typestore(Stores.ROS2_HUMBLE)
        kinds = store.types
        header, stamp = kinds["std_msgs/msg/Header"], kinds["builtin_interfaces/msg/Time"]
        vector, point = kinds["geometry_msgs/msg/Vector3"], kinds["geometry_msgs/msg/Point"]
        turn, pose = kinds["geometry_msgs/msg/Quaternion"], kinds["geometry_msgs/msg/Pose"]
        with_covariance = kinds["geometry_msgs/msg/PoseWithCovariance"]
        twist = kinds["geometry_msgs/msg/Twist"](vector(0, 0, 0), vector(0, 0, 0))
        moving = kinds["geometry_msgs/msg/TwistWithCovariance"](twist, np.zeros(36))
        odometry, link = kinds["nav_msgs/msg/Odometry"], kinds["geometry_msgs/msg/TransformStamped"]
        transforms = kinds["tf2_msgs/msg/TFMessage"]
        with Writer(tmp_path / "bag", version=9) as writer:
            odom = writer.add_connection("/odom", odometry.__msgtype__, typestore=store)
            tf = writer.add_connection("/tf", transforms.__msgtype__, typestore=store)
            for n, (time, (x, y, theta)) in enumerate(zip(*self.drive(), strict=True)):
                at = stamp(int(time), int(time % 1 * 1e9))
                x_told = 1e200 if n == 7 else x
                q = turn(0.0, 0.0, np.sin(theta / 2), np.cos(theta / 2))
                where = with_covariance(pose(point(x_told, y, 0.0), q), np.zeros(36))
                message = odometry(header(at, "odom"), "base_link", where, moving)
                writer.write(
                    odom, int(time * 1e9), store.serialize_cdr(message, odometry.__msgtype__)
                )
                shift = kinds["geometry_msgs/msg/Transform"]
                ahead = link(
                    header(at, "map"), "odom", shift(vector(1.0, 0.0, 0.0), turn(0, 0, 0, 1))
                )
                chain = transforms(
                    [ahead, link(header(at, "odom"), "base_link", shift(vector(x, y, 0.0), q))]
                )
                writer.write(
                    tf, int(time * 1e9), store.serialize_cdr(chain, transforms.__msgtype__)
                )
        return tmp_path / "bag"

    def drive(self):
        stamps = np.arange(1000.0, 1050.0, 0.1)
        return stamps, rounds(stamps)

    @pytest.mark.slow
    def test_its_odometry_is_judged_and_what_is_absurd_counted(self, tmp_path, bag, capsys):
        write_tum(tmp_path / "truth.tum", Trajectory.of_poses(*self.drive()))
        out = tmp_path / "out"
        files = "--recording", str(bag), "--truth", str(tmp_path / "truth.tum"), "--out", str(out)
        assert main(["evaluate", *files]) == 0
        results = json.loads((out / "results.json").read_text())
        assert results["experiment"]["poses"] == 499
        assert mean(results) < 1e-6
        assert "left out: 1 of 500 poses" in capsys.readouterr().out

    @pytest.mark.slow
    def test_transforms_are_followed_through(self, tmp_path, bag, capsys):
        write_tum(tmp_path / "estimate.tum", Trajectory.of_poses(*self.drive()))
        given = "--truth", str(bag), "--truth-topic"
        code, results = evaluate(tmp_path, *given, "tf:map.base_link")
        assert code == 0
        assert mean(results) == pytest.approx(1.0, abs=1e-6)
        assert evaluate(tmp_path, *given, "tf:earth.base_link")[0] == 2
        assert "tf:map.odom, tf:odom.base_link" in capsys.readouterr().err
        assert evaluate(tmp_path, *given, "/scan")[0] == 2
        assert "valid are /odom, tf:map.odom, tf:odom.base_link" in capsys.readouterr().err

    def test_a_topic_of_what_is_no_bag_is_refused(self, tmp_path, capsys):
        write_tum(tmp_path / "estimate.tum", eight())
        given = "--truth", str(tmp_path / "estimate.tum"), "--truth-topic", "/odom"
        assert evaluate(tmp_path, *given)[0] == 2
        assert "is no bag" in capsys.readouterr().err


def test_a_few_bends_of_a_path_move_no_clock():
    """Of 2129's figure-eights only three changes of sides tell the time; 6 ms were corrected."""
    assert judged(faulty_pair, 2129).added == 0


def test_a_robot_lost_for_a_third_of_the_run_is_not_of_another_run():
    """It was refused: speeds correlate by 0.74, and poses of zero turned the alignment."""
    assert not judged(faulty_pair, 61).refused


@pytest.mark.slow
@pytest.mark.parametrize("seed", [17, 35, 61])
@pytest.mark.parametrize("make", [clean_pair, faulty_pair])
def test_pairs_that_are_made_by_a_seed_are_judged_rightly(make, seed):
    """The study itself is ``python -m benchmarks.clock_offsets``."""
    verdict = judged(make, seed)
    assert not verdict.refused
    assert not verdict.is_false, verdict
    assert not verdict.is_by_a_lap, verdict
