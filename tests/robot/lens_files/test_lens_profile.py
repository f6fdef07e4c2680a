"""A profile's lens is written, read again, applied and kept; nothing wrong in it goes unnoticed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from app.command_line import main
from app.engine.build import build_program
from app.engine.robots import robot_spec
from app.settings.config import Config
from robot.camera import Lens
from robot.description.lens_table import MeasuredLens
from robot.description.profile import Profile, load_profile
from robot.description.spec import RobotSpec, SpecError
from robot.distortion import COEFFICIENTS

SPEC = RobotSpec.load()
MATRIX = np.array([[533.0, 0, 342.0], [0, 534.0, 234.0], [0, 0, 1]])


def lens_of(model: str = "plumb_bob", coefficients: object = None, **size: int) -> Lens:
    bends = (
        np.linspace(0.01, 0.02, len(COEFFICIENTS[model])) if coefficients is None else coefficients
    )
    return Lens(size.get("width", 640), size.get("height", 480), MATRIX, bends, model=model)


def profile(lens: Lens, sd: np.ndarray | None = None) -> Profile:
    return replace(Profile.unmeasured("spike", "lens"), lens=MeasuredLens.of(lens, sd))


def written(folder: Path, text: str) -> Path:
    path = folder / "profile.toml"
    path.write_text(text, encoding="utf-8")
    return path


@given(
    st.sampled_from(sorted(COEFFICIENTS)).flatmap(
        lambda model: st.tuples(
            st.just(model),
            arrays(np.float64, len(COEFFICIENTS[model]), elements=st.floats(-10, 10)),
            st.none() | arrays(np.float64, 4 + len(COEFFICIENTS[model]), elements=st.floats(0, 9)),
        )
    )
)
def test_what_is_written_is_read_again(tmp_path_factory, case) -> None:
    model, coefficients, sd = case
    text = profile(lens_of(model, coefficients), sd).to_toml()
    lens = load_profile(written(tmp_path_factory.getbasetemp(), text)).lens
    assert lens is not None
    assert (lens.lens.width, lens.lens.height, lens.lens.model) == (640, 480, model)
    np.testing.assert_array_equal(lens.lens.matrix, MATRIX)
    np.testing.assert_array_equal(lens.lens.distortion, coefficients)
    np.testing.assert_array_equal(lens.sd, np.full(len(lens.sd), np.nan) if sd is None else sd)


def test_the_robot_looks_through_it_but_the_drawing_stays(tmp_path: Path) -> None:
    before = profile(lens_of("equidistant"))
    values = before.values.copy()
    values[6] = 0.01  # the focal length is one per cent longer than the lens's
    config = Config(profile=str(written(tmp_path, replace(before, values=values).to_toml())))
    spec = robot_spec(config)
    assert spec.lens.model == "equidistant"
    assert spec.lens.matrix[0] == pytest.approx([1.01 * 533, 0, 342])
    assert spec.lens.readout == SPEC.lens.readout
    assert spec.as_drawn.lens.matrix[0, 2] == 319.5


def test_a_simulated_robot_is_seen_through_it(tmp_path: Path) -> None:
    """The simulated camera keeps the described lens; what is believed of it is the profile's."""
    path = str(written(tmp_path, profile(lens_of()).to_toml()))
    program = build_program(Config(robot="kinematic", profile=path))
    try:
        assert program.engine.localization.scanner.view.lens.matrix[0, 2] == 342
        for _ in range(5):
            program.engine.step()
    finally:
        program.robot.close()


TEXT = profile(lens_of()).to_toml()


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("width = 640", "width = 1280", "is for pictures of 1280 x 480 px; the robot's are of 640"),
        ("width = 640", "width = 640.5", "lens.width is 640.5; valid is a whole number"),
        ("width = 640\n", "", "lens.width is None; valid is a whole number"),
        ("height = 480", "height = 0", "lens: a picture of 640 x 0 px"),
        ('"plumb_bob"', '"fisheye"', "lens.model is 'fisheye'; valid are plumb_bob"),
        ('"plumb_bob"', '"equidistant"', "there is no lens.k3|there is no lens.p1"),
        ("fx = 533.0", "fx = -533.0", "lens: the focal lengths in camera_matrix must be positive"),
        ("fx = 533.0", "fx = inf", "lens.fx is inf; valid is up to"),
        ("fx = 533.0", "fx = nan", "lens.fx is nan; valid is up to"),
        ("fx = 533.0", "fx = true", "lens.fx is True; valid is a number"),
        ("cy = 234.0\n", "", "lens.cy is None; valid is a number"),
        ("cy = 234.0", "cy = 234.0\nsize = 3", "there is no lens.size; valid are cx"),
    ],
)
def test_what_is_wrong_in_it_is_refused(old: str, new: str, words: str, tmp_path: Path) -> None:
    assert TEXT.count(old) == 1
    path = written(tmp_path, TEXT.replace(old, new))
    with pytest.raises(SpecError, match=words):
        load_profile(path).applied_to(SPEC)


def test_a_lens_that_is_no_table_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path, "lens = 3\n" + TEXT.split("\n[lens]")[0])
    with pytest.raises(SpecError, match="lens is no table"):
        load_profile(path)


@pytest.mark.slow
def test_a_drive_uses_the_profiles_lens_and_keeps_it(tmp_path: Path, capsys) -> None:
    """The profile's lens is one per cent longer than that of the robot: the drive tells."""
    longer = replace(SPEC.lens, matrix=SPEC.lens.matrix * [[1.01, 1, 1], [1, 1.01, 1], [1, 1, 1]])
    path = written(tmp_path, profile(longer, np.full(9, 0.1)).to_toml())
    given = ["--robot", "kinematic", "--seconds", "12", "--out", str(path)]
    assert main(["calibrate", "drive", *given]) == 0
    after = load_profile(path)
    assert after.lens is not None
    assert after.lens.lens.matrix[0, 0] == pytest.approx(1.01 * 530)
    assert after.values[6] == pytest.approx(-0.0099, abs=0.003)
    assert after.applied_to(SPEC).lens.matrix[0, 0] == pytest.approx(530, abs=1.6)


def test_a_drive_refuses_a_lens_for_other_pictures(tmp_path: Path, capsys) -> None:
    text = profile(lens_of(width=1280, height=720)).to_toml()
    path = written(tmp_path, text)
    given = ["--robot", "kinematic", "--seconds", "12", "--out", str(path)]
    assert main(["calibrate", "drive", *given]) == 1
    assert "lens is for pictures of 1280 x 720 px" in capsys.readouterr().err
    assert path.read_text() == text


def test_a_drive_does_not_overwrite_the_profile_of_another_robot(tmp_path: Path, capsys) -> None:
    text = TEXT.replace(f'robot = "{SPEC.name}"', 'robot = "other"')
    assert text != TEXT
    path = written(tmp_path, text)
    given = ["--robot", "kinematic", "--seconds", "12", "--out", str(path)]
    assert main(["calibrate", "drive", *given]) == 1
    assert "is of the robot 'other'" in capsys.readouterr().err
    assert path.read_text() == text


@pytest.mark.parametrize("x", ["9", "nan"])
def test_a_start_that_is_not_on_the_field_is_refused(x: str, tmp_path: Path, capsys) -> None:
    path = tmp_path / "profile.toml"
    given = ["--robot", "kinematic", "--seconds", "12", "--start", x, "0", "0"]
    assert main(["calibrate", "drive", *given, "--out", str(path)]) == 2
    assert "is not on the field square" in capsys.readouterr().err
    assert not path.exists()


def test_a_skew_is_kept(tmp_path: Path) -> None:
    skewed = MATRIX.copy()
    skewed[0, 1] = -0.97
    lens = Lens(640, 480, skewed, np.full(4, 0.01), model="equidistant")
    read = load_profile(written(tmp_path, profile(lens).to_toml())).lens
    assert read is not None
    np.testing.assert_array_equal(read.lens.matrix, skewed)
    assert "skew" not in profile(lens_of()).to_toml()
