"""Robots of features: by their own description, and named if they are none."""

from __future__ import annotations

import threading
from types import SimpleNamespace

import numpy as np
import pytest
from engine_runs import PERFECT, drive, run

from app.engine.build import build_program
from app.engine.plugging import plug_in, plugged
from app.engine.robot_kind import RobotKind
from app.engine.robots import own_file, profile_file, robot_spec
from app.engine.simulated_robots import build_kinematic
from app.feature import Feature
from app.feature_search import FeatureError
from app.features.calibration.written_file import written_file
from app.features.lab.calibrate.command import calibrate_drive
from app.features.recordings.contents import contents_of
from app.features.ros.export.export import export_ros2
from app.settings.config import Config
from app.settings.profile_files import write_profile
from robot.description.profile import Profile
from robot.description.spec import RobotSpec
from robot.errors import CommandError
from robot.interface import RobotError
from robot.lens_files.camera_info import camera_info
from robot.localization.estimate import State
from robot.settings import SettingError

NAME = "snail"


@pytest.fixture(autouse=True)
def put_back():
    before = plugged().features
    yield
    plug_in(before)


@pytest.fixture(scope="module")
def own(tmp_path_factory) -> RobotSpec:
    """Other wheels, another lens, and a camera that is higher and looks farther ahead."""
    folder = tmp_path_factory.mktemp("snail")
    spike = RobotSpec.load()
    turn, shift = np.eye(4), np.eye(4)
    turn[:3, :3] = [[1, 0, 0], [0, np.cos(0.1), -np.sin(0.1)], [0, np.sin(0.1), np.cos(0.1)]]
    shift[2, 3] = 0.04
    spec = spike.with_wheels((0.035, 0.035), 0.13)
    spec = spec.with_camera(spike.lens, shift @ spike.robot_from_camera @ turn)
    text = spec.urdf.replace(f'name="{spike.name}"', f'name="{NAME}"', 1)
    (folder / "snail.urdf").write_text(text.replace("pi_camera.yaml", "snail_lens.yaml"))
    (folder / "snail_lens.yaml").write_text(camera_info(spike.lens))
    return RobotSpec.load(folder / "snail.urdf")


def plug(**kind):
    made = RobotKind(name=NAME, about="slow", **kind)
    feature = Feature(name="snails", about="", robots=(lambda: (made,),))
    return plug_in(plugged().features.adding(feature)).failures


def config(**settings):
    return Config(robot=NAME, map="square", sim=PERFECT, **settings)


def error_of(program) -> float:
    last = run(program, 6.0, drive(0.1, 0.6))[-1]
    program.robot.close()
    assert last.integrity.state is State.CERTAIN
    return last.pose.distance_to(last.truth)


def knows_its_description(spec):
    """Takes no description of ours, as a robot may that has none of its own in its kind."""

    def build(blueprint):
        return build_kinematic(type(blueprint)(**(vars(blueprint) | {"spec": spec})))

    return build


@pytest.mark.parametrize("how", ["by its kind", "by itself", "given"])
def test_wheels_drive_and_scanner_are_those_of_its_own_description(how, own):
    if how == "by its kind":
        assert plug(build=build_kinematic, description=lambda: own, is_simulated=True) == ()
        assert robot_spec(config()) is own
    else:
        assert plug(build=knows_its_description(own), is_simulated=True) == ()
    program = build_program(config())
    if how == "given":
        given = program.robot
        program = build_program(Config(robot="kinematic", map="square"), robot=given)
    assert program.robot.spec is own
    np.testing.assert_array_equal(
        program.engine.scanner.table.lines(9),
        build_program(config(), robot=program.robot).engine.scanner.table.lines(9),
    )
    assert error_of(program) < 0.004


def test_a_real_one_has_a_profile_of_its_own(own, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    assert plug(build=build_kinematic, description=lambda: own) == ()
    file = own_file(config())
    assert file.name == f"{NAME}.toml"
    assert profile_file(config()) is None
    assert written_file(config()) == file
    write_profile(file, Profile.unmeasured(NAME, "a test"))
    assert profile_file(config()) == file
    assert robot_spec(config()).name == NAME


@pytest.mark.slow
def test_its_calibration_says_how_it_is_used_and_can_be(own, tmp_path, capsys):
    assert plug(build=build_kinematic, description=lambda: own, is_simulated=True) == ()
    out = tmp_path / "profile.toml"
    assert calibrate_drive({"robot": NAME, "map": "square", "seconds": 30.0, "out": out}) == 0
    used = f"use it by: brickpose run --robot {NAME} --profile {out}"
    assert used in capsys.readouterr().out
    assert robot_spec(config(profile=str(out))).name == NAME


def test_ros_and_recordings_have_its_description(own, tmp_path):
    assert plug(build=build_kinematic, description=lambda: own, is_simulated=True) == ()
    export_ros2(tmp_path / "ros", config())
    exported = RobotSpec.load(tmp_path / "ros" / "urdf" / "brickpose.urdf")
    program = build_program(config())
    for each in contents_of(program).attachments:
        if each.name.startswith("robot/"):
            (tmp_path / each.name.removeprefix("robot/")).write_bytes(each.data)
    recorded = RobotSpec.load(tmp_path / "robot.urdf")
    program.robot.close()
    for spec in (exported, recorded):
        assert (spec.name, spec.track) == (NAME, own.track)
        np.testing.assert_array_equal(spec.lens.matrix, own.lens.matrix)
        np.testing.assert_array_equal(spec.lens.distortion, own.lens.distortion)


class Nameless:
    """Has what a robot has, but for its name."""

    def __init__(self, blueprint):
        self.spec, self.name = blueprint.spec, None

    def read(self): ...
    def write(self, velocities): ...
    def close(self): ...


class Undescribed(Nameless):
    """Lacks its description."""

    def __init__(self, blueprint):
        self.name = "Snail"


class Silent(Nameless):
    """Has a word for what cannot be called."""

    def __init__(self, blueprint):
        super().__init__(blueprint)
        self.name, self.close = "Snail", "closed"


@pytest.mark.parametrize(
    ("build", "words"),
    [
        (lambda blueprint: {}["motor"], r"KeyError: 'motor' \(test_robots.py:\d+\)"),
        (Nameless, "TypeError: the robot's name is None; valid is a str"),
        (Undescribed, "TypeError: the robot's spec is None; valid is a RobotSpec"),
        (Silent, "TypeError: the robot has no close"),
        (lambda blueprint: None, "TypeError: the robot's name is None"),
    ],
)
def test_one_that_cannot_be_built_is_named_with_its_feature(build, words):
    assert plug(build=build) == ()
    with pytest.raises(FeatureError, match=f"The feature snails cannot be used: {words}"):
        build_program(config())


def test_a_description_that_fails_is_named_with_its_feature():
    assert plug(build=build_kinematic, description=lambda: {}["urdf"]) == ()
    with pytest.raises(FeatureError, match="The feature snails cannot be used: KeyError: 'urdf'"):
        robot_spec(config())


@pytest.mark.parametrize("name", ["sim", "auto", "buildhat"])
def test_a_name_that_is_taken_is_refused(name):
    made = RobotKind(name=name, about="", build=build_kinematic)
    feature = Feature(name="snails", about="", robots=(lambda: (made,),))
    (failure,) = plug_in(plugged().features.adding(feature)).failures
    assert f"there is a robot {name!r} already" in failure


def test_a_robot_of_a_feature_that_is_left_out_is_refused_with_its_name():
    plug_in(type(plugged().features)(left_out=("snails",)))
    with pytest.raises(SettingError, match=r"robot is 'snail'; valid are auto.*; without snails$"):
        build_program(config())


@pytest.mark.parametrize("wheels", [None, [1.0], [np.nan, 0.0]])
def test_one_that_does_not_say_what_it_applies_stops_with_words(wheels):
    program = build_program(Config(robot="kinematic", map="square"))
    program.robot.write = lambda velocities: wheels
    with pytest.raises(RobotError, match=r"robot's applied velocities are .* finite numbers"):
        program.engine.step()


def test_one_that_does_not_wait_is_told():
    stop = threading.Event()

    def build(blueprint):
        made = build_kinematic(blueprint)

        def read():
            reading = made.read()
            if reading.stamp > 12.0:
                stop.set()
            return reading

        return SimpleNamespace(
            name="Snail", spec=made.spec, read=read, write=made.write, close=made.close
        )

    assert plug(build=build) == ()
    engine = build_program(config()).engine
    engine.run(stop)
    (problem,) = engine.latest.get().problems.present
    assert problem.startswith("The robot's clock is too fast: does its read wait")


def test_one_that_was_built_is_closed_if_the_program_cannot_be():
    closed = []

    def build(blueprint):
        robot = build_kinematic(blueprint)
        robot.close = lambda: closed.append(True)
        return robot

    def refuse(config, robot, field):
        raise CommandError("there is no lamp")

    made = RobotKind(name=NAME, about="slow", build=build)
    hooks = {"robots": (lambda: (made,),), "companions": (refuse,)}
    feature = Feature(name="snails", about="", **hooks)
    assert plug_in(plugged().features.adding(feature)).failures == ()
    with pytest.raises(CommandError, match="there is no lamp"):
        build_program(config())
    assert closed == [True]
