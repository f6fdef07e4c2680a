"""What befalls a robot while it drives, and floors that are not as drawn."""

import numpy as np
import pytest

from app.features.lab.evaluate_options import MISHAPS as LISTED
from app.features.lab.evaluation.integrity.claims import quarter_off
from app.features.lab.evaluation.integrity.mishaps import (
    LATE,
    MISHAP,
    MISHAPS,
    SHIFT,
    LineCourse,
    PushedRobot,
    ShadowedRobot,
    StuckRobot,
    apply_any_condition,
    jitters,
    laid_by_hand,
    longest_edge,
    steps_late,
    with_piece_elsewhere,
    without_piece,
)
from app.features.lab.evaluation.integrity.summary import EXPECTED
from app.settings.conditions import CONDITIONS
from app.settings.config import DOCS, MAPS, Config
from robot.description.spec import RobotSpec
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.interface import Frame, Reading
from robot.settings import SettingError


class Rolling:
    """A robot that rolls ahead as commanded, with a picture at each reading."""

    name, spec = "rolling", RobotSpec.load()

    def __init__(self):
        self.stamp, self.turned, self.pose = 0.0, np.zeros(2), Pose2()
        self.velocities = np.zeros(2)

    def read(self):
        self.stamp = round(self.stamp + 0.02, 6)
        self.turned = self.turned + 0.02 * self.velocities
        lens = self.spec.lens
        frame = Frame(self.stamp, np.full((lens.height, lens.width), 200, np.uint8))
        return Reading(self.stamp, self.turned, self.velocities, frame, truth=self.pose)

    def write(self, velocities):
        self.velocities = velocities
        return velocities

    def place(self, pose):
        self.pose = pose

    def close(self):
        pass


def driven(make, seconds=8.0, seed=3):
    robot = Rolling()
    disturbed = make(robot, np.random.default_rng([seed, MISHAP]))
    readings = []
    while robot.stamp < seconds:
        readings.append(disturbed.read())
        disturbed.write(np.full(2, 3.0))
    return robot, disturbed, readings


def test_wheels_of_a_stuck_robot_turn_on_while_it_stands():
    robot, disturbed, readings = driven(StuckRobot)
    turned = np.array([reading.positions[0] for reading in readings])
    # Once it is free, it begins from rest.
    assert np.isclose(np.diff(turned)[1:], 0.06).sum() >= len(turned) - 3
    assert robot.turned[0] == pytest.approx(turned[-1] - 2.0 * 3.0, abs=0.13)
    assert 3 <= disturbed.begin <= 5


def test_a_pushed_robot_is_ahead_and_its_wheels_say_nothing_of_it():
    robot, _, readings = driven(PushedRobot)
    assert 0.10 <= robot.pose.x <= 0.25 and robot.pose.y == 0
    turned = np.array([reading.positions[0] for reading in readings])
    np.testing.assert_allclose(np.diff(turned)[1:], 0.06, atol=1e-9)


@pytest.mark.parametrize("make", [steps_late, jitters])
def test_no_picture_comes_before_its_stamp_and_stamps_increase(make):
    _, _, readings = driven(make, 14.0)
    stamps = [(r.frame.stamp, r.stamp) for r in readings if r.frame is not None]
    assert all(stamp <= now + 1e-9 for stamp, now in stamps)
    assert (np.diff([stamp for stamp, _ in stamps]) > 0).all()
    if make is steps_late:
        assert min(stamp for stamp, _ in stamps if stamp > 6) >= 6 + LATE - 0.021


def test_a_shadow_travels_with_the_robot():
    _, _, readings = driven(ShadowedRobot, 0.1)
    images = {reading.frame.image.tobytes() for reading in readings}
    assert len(images) == 1
    image = readings[0].frame.image
    assert set(np.unique(image)) == {60, 200} and 0.02 < (image == 60).mean() < 0.4


def test_the_longest_piece_of_tape_is_elsewhere_or_missing():
    field, rng = load_field("stub", MAPS), np.random.default_rng(0)
    start, end = longest_edge(field)
    ahead = (end - start) / np.hypot(*(end - start))
    left = np.array([-ahead[1], ahead[0]])
    missing, elsewhere = without_piece(field, rng), with_piece_elsewhere(field, rng)
    np.testing.assert_array_equal(missing.edges, field.edges)

    def dark(floor, beside):
        point = (start + end) / 2 + 0.1 * ahead + beside * left
        column, row = np.rint(floor.pixel_from_map @ [*point, 1]).astype(int)
        return bool(floor.image[row, column] < 128)

    assert dark(field.floor, 0.025)
    assert not dark(missing.floor, 0.025) and not dark(elsewhere.floor, 0.025)
    assert dark(elsewhere.floor, 0.025 + SHIFT) or dark(elsewhere.floor, 0.025 - SHIFT)


def test_tape_that_is_laid_by_hand_is_off_by_a_centimetre():
    field = load_field("square", MAPS)
    laid = laid_by_hand(field, np.random.default_rng(4)).floor
    other = (laid.image < 128) != (field.floor.image < 128)
    tape = (field.floor.image < 128).mean()
    assert 0.03 * tape < other.mean() < tape
    assert (laid.image < 128).mean() == pytest.approx(tape, rel=0.1)


def test_a_line_is_driven_to_and_fro_beside_the_tape():
    course = LineCourse.beside_tape(load_field("square", MAPS), np.random.default_rng(1))
    stamps = np.arange(0, 60, 0.02)
    commands = [course.command(float(stamp)) for stamp in stamps]
    assert {command.v for command in commands} == {0.0, course.speed}
    assert not any(command.v and command.omega for command in commands)
    assert 0.06 <= course.speed <= 0.20 and 0.5 < course.way <= 0.9


def test_a_quarter_is_a_quarter_about_the_middle_of_the_tape():
    field = load_field("square", MAPS)
    turned = quarter_off(Pose2(0.3, 0.1, 0.0), field)
    assert turned.distance_to(Pose2(-0.1, 0.3)) < 1e-6
    assert turned.theta == pytest.approx(np.pi / 2)


def test_each_mishap_is_listed_documented_and_no_setting():
    assert tuple(MISHAPS) == LISTED and not set(MISHAPS) & set(CONDITIONS)
    told = (DOCS / "evaluation.md").read_text(encoding="utf-8")
    assert [name for name in MISHAPS if f"`{name}`" not in told] == []
    assert set(EXPECTED) <= {*MISHAPS, *CONDITIONS}
    assert apply_any_condition(Config(), "shrunk").sim.camera.floor_scale == 0.97
    with pytest.raises(SettingError, match="own-shadow"):
        apply_any_condition(Config(), "lunar")
