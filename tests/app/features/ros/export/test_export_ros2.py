"""The files for ROS 2 say what the robot's description says."""

import dataclasses
import math
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml

from app.command_line import main
from app.features.ros.export.export import MOCK, export_ros2
from app.features.ros.export.nav2 import AMCL_NAMES
from app.settings.config import MAPS, Config
from robot.description.spec import RobotSpec
from robot.driving.drive_controller import DriveSettings
from robot.fields.field_loading import load_field
from robot.fields.grid_map import load_map_yaml


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("robot")
    assert main(["export", "ros2", str(folder)]) == 0
    return folder


@pytest.fixture(scope="module")
def spec():
    return RobotSpec.load()


def parameters(folder, file, *node) -> dict:
    content = yaml.safe_load((folder / "config" / f"{file}.yaml").read_text())
    for name in node:
        content = content[name]
    return content["ros__parameters"]


def test_the_description_is_the_robot_with_wheels_that_ros2_control_can_drive(folder, spec):
    again = RobotSpec.load(folder / "urdf" / "brickpose.urdf")
    assert again.joints == spec.joints
    np.testing.assert_array_equal(again.robot_from_camera, spec.robot_from_camera)
    np.testing.assert_array_equal(again.lens.matrix, spec.lens.matrix)
    system = ElementTree.parse(folder / "urdf" / "brickpose.urdf").find("ros2_control")
    assert system.find("hardware/plugin").text == MOCK
    for joint in system.findall("joint"):
        assert [one.get("name") for one in joint.findall("command_interface")] == ["velocity"]
        states = {one.get("name") for one in joint.findall("state_interface")}
        assert states == {"position", "velocity"}


def test_another_plugin_is_named_where_it_belongs(tmp_path, spec):
    export_ros2(tmp_path, Config(), "my_robot/Wheels")
    root = ElementTree.parse(tmp_path / "urdf" / "brickpose.urdf")
    assert [one.text for one in root.iter("plugin")] == ["my_robot/Wheels"]


def test_the_wheels_are_those_of_the_description(folder, spec):
    wheels = parameters(folder, "controllers", "diff_drive_controller")
    left, right = spec.axle
    assert wheels["left_wheel_names"] == [spec.joints[left].name]
    assert wheels["right_wheel_names"] == [spec.joints[right].name]
    assert wheels["wheel_separation"] == pytest.approx(spec.track)
    assert wheels["wheel_radius"] == pytest.approx(spec.wheel_radius)
    manager = parameters(folder, "controllers", "controller_manager")
    assert manager["diff_drive_controller"]["type"] == "diff_drive_controller/DiffDriveController"


def test_limits_have_the_signs_that_the_controller_wants(tmp_path, spec):
    drive = DriveSettings(max_velocity=0.2, max_acceleration=0.5, max_deceleration=0.7)
    export_ros2(tmp_path, Config(drive=drive))
    wheels = parameters(tmp_path, "controllers", "diff_drive_controller")
    limits = wheels["linear"]["x"]
    assert math.isnan(limits.pop("max_jerk"))
    assert math.isnan(limits.pop("min_jerk"))
    assert limits == {
        "max_velocity": 0.2,
        "min_velocity": -0.2,
        "max_acceleration": 0.5,
        "max_deceleration": -0.7,
        "max_acceleration_reverse": -0.5,
        "max_deceleration_reverse": 0.7,
    }
    assert wheels["angular"]["z"]["max_velocity"] <= spec.max_omega


def test_amcl_has_our_values_under_its_own_names(folder):
    amcl = parameters(folder, "nav2", "amcl")
    ours: dict = {}
    for group in dataclasses.fields(Config().localization):
        ours |= dataclasses.asdict(getattr(Config().localization, group.name))
    assert {name: amcl[name] for name in AMCL_NAMES} == {name: ours[name] for name in AMCL_NAMES}
    assert amcl["robot_model_type"] == "nav2_amcl::DifferentialMotionModel"
    assert (amcl["base_frame_id"], amcl["odom_frame_id"]) == ("base_footprint", "odom")


def test_costmaps_have_the_robots_outline(folder, spec):
    for name in ("local_costmap", "global_costmap"):
        footprint = yaml.safe_load(parameters(folder, "nav2", name, name)["footprint"])
        np.testing.assert_allclose(footprint, spec.outline, atol=1e-4)


def test_the_map_is_the_field_and_is_where_the_server_looks(folder):
    named = parameters(folder, "nav2", "map_server")["yaml_filename"]
    field = load_field("square", MAPS)
    expected = field.occupancy(Config().ros2.map_resolution)
    found = load_map_yaml(folder / named)
    np.testing.assert_array_equal(found.data, expected.data)
    assert found.origin == expected.origin


def test_a_file_in_the_way_is_named(tmp_path, capsys):
    (tmp_path / "taken").write_text("x")
    assert main(["export", "ros2", str(tmp_path / "taken")]) == 2
    assert "valid is a folder" in capsys.readouterr().err
