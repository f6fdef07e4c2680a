"""Trajectories as spreadsheets and careless programs write them: read, told, or named."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from app.features.lab.evaluation.recorded import evaluate_recording
from app.features.lab.evaluation.recorded_words import recorded_lines
from app.features.lab.trajectories.reading import parse_trajectory, read_trajectory
from app.trajectories.trajectory import LEFT_OUT, TrajectoryError

START = 1_700_000_000.0
TIMES = np.arange(0, 40, 0.1)
HEADER = "stamp x y z qx qy qz qw"


def poses(times: np.ndarray = TIMES, *, ahead: float = 0.0, noise: float = 0.0) -> np.ndarray:
    """x, y, theta (n, 3) of a winding drive, of a body so far ahead [m]."""
    rng = np.random.default_rng(1)
    x, y = 2 * np.sin(0.15 * times), 1.2 * np.sin(0.31 * times)
    theta = np.arctan2(1.2 * 0.31 * np.cos(0.31 * times), 2 * 0.15 * np.cos(0.15 * times))
    result = np.column_stack([x + ahead * np.cos(theta), y + ahead * np.sin(theta), theta])
    result[:, :2] += rng.normal(0, noise, (len(times), 2))
    return result


def lines_of(stamps: np.ndarray, places: np.ndarray, form: str = "%.6f") -> list[str]:
    return [
        f"{form % stamp} {x:.6f} {y:.6f} 0 0 0 {np.sin(theta / 2):.9f} {np.cos(theta / 2):.9f}"
        for stamp, (x, y, theta) in zip(stamps, places, strict=True)
    ]


PLAIN = lines_of(START + TIMES, poses())


@pytest.mark.parametrize("header", [True, False])
@pytest.mark.parametrize(
    ("between", "point"), [(";", "."), (";", ","), ("; ", ","), (" ", ","), ("\t", ",")]
)
def test_semicolons_and_decimal_commas_are_read(between: str, point: str, header: bool) -> None:
    rows = [line.replace(".", point).replace(" ", between) for line in PLAIN]
    if header:
        rows.insert(0, HEADER.replace(" ", between))
    read = parse_trajectory("\n".join(rows), "a.csv")
    plain = parse_trajectory("\n".join(PLAIN), "a.tum")
    np.testing.assert_array_equal(read.stamps, plain.stamps)
    np.testing.assert_array_equal(read.poses, plain.poses)


@pytest.mark.slow
@pytest.mark.parametrize("cell", ["nan", "inf", "-NaN"])
def test_some_lines_without_a_pose_are_left_out_and_counted(cell: str, tmp_path: Path) -> None:
    lines = PLAIN.copy()
    for place in (0, 200, 399):
        cells = lines[place].split()
        cells[1 + place % 3] = cell
        lines[place] = " ".join(cells)
    lines[100] = f"{START + 10:.6f} 0 0 0 0 0 0 0"  # nothing was known
    for name, rows in (("truth", lines), ("headed", [HEADER, *lines])):
        (tmp_path / f"{name}.tum").write_text("\n".join(rows))
        trajectory = read_trajectory(tmp_path / f"{name}.tum")
        assert len(trajectory) == len(PLAIN) - 4
        assert f"{LEFT_OUT} 4 of 400 poses" in trajectory.notes[-1]
    (tmp_path / "estimate.tum").write_text("\n".join(lines_of(START + TIMES, poses(noise=0.005))))
    results = evaluate_recording(
        tmp_path / "estimate.tum", tmp_path / "truth.tum", tmp_path / "out"
    )
    said = list(recorded_lines(results))
    assert any("left out: 4 of 400 poses of" in line for line in said)
    assert any("on 396 pairs of poses, which cover" in line for line in said)


def test_many_lines_without_a_pose_are_refused() -> None:
    lines = [line.replace(" 0 ", " nan ", 1) if n % 5 == 0 else line for n, line in
             enumerate(PLAIN)]  # fmt: skip
    with pytest.raises(TrajectoryError, match="line 1: a number is not finite"):
        parse_trajectory("\n".join(lines), "a.tum")


@pytest.mark.parametrize("form", ["%g", "%.0e", "%.9g", "float32"])
def test_stamps_that_have_lost_their_digits_are_named(form: str) -> None:
    stamps = START + TIMES
    if form == "float32":
        stamps, form = stamps.astype(np.float32).astype(float), "%.6f"
    with pytest.raises(TrajectoryError, match=r"400 poses at only .* stamps: .*%g. or as float32"):
        parse_trajectory("\n".join(lines_of(stamps, poses(), form)), "a.tum")


@pytest.mark.parametrize(("bodies", "apart"), [(2, 0.3), (3, 0.5)])
def test_several_frames_in_a_file_are_told(bodies: int, apart: float) -> None:
    of_each = [lines_of(START + TIMES, poses(ahead=body * apart)) for body in range(bodies)]
    rows = [row for rows in zip(*of_each, strict=True) for row in rows]
    trajectory = parse_trajectory("\n".join(rows), "a.tum")
    assert f"a.tum has {bodies}.0 poses a stamp" in trajectory.notes[-1]
    assert "several frames or bodies" in trajectory.notes[-1]


def test_repeated_poses_and_a_few_repeated_stamps_are_nothing_strange() -> None:
    twice = [line for line in PLAIN for _ in range(2)]
    assert parse_trajectory("\n".join(twice), "a.tum").notes == ()
    stamps = (START + TIMES).copy()
    stamps[1::7] = stamps[::7][: len(stamps[1::7])]
    assert parse_trajectory("\n".join(lines_of(stamps, poses())), "a.tum").notes == ()


@pytest.mark.slow
@pytest.mark.parametrize("still", [5.0, 10.0, 20.0])
@pytest.mark.parametrize("begins", [0.0, 12.0])
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_a_robot_that_stands_for_long_is_of_the_same_run(
    still: float, begins: float, noise: float, tmp_path: Path
) -> None:
    """Ten seconds of standing are no motion to compare, but they are no other run either."""
    driven = np.where(begins > TIMES, TIMES, np.maximum(TIMES - still, begins))
    (tmp_path / "truth.tum").write_text("\n".join(lines_of(START + TIMES, poses(driven))))
    seen = lines_of(START + TIMES, poses(driven, noise=noise))
    (tmp_path / "estimate.tum").write_text("\n".join(seen))
    results = evaluate_recording(
        tmp_path / "estimate.tum", tmp_path / "truth.tum", tmp_path / "out"
    )
    assert results["experiment"]["clock_offset_added_s"] == 0
    assert results["experiment"]["judged"] > 0.99
    error = results["methods"]["amcl"]["ate_rmse_m"]["mean"]
    assert error == pytest.approx(noise * 2**0.5, rel=0.1, abs=1e-4)
