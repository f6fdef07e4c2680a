"""Which motor drives which joint is read from the description, for robots of any shape."""

import pytest

from robot.description.spec import SPIKE, RobotSpec, SpecError
from robot.description.urdf import parse_xml
from robot.description.wiring import Wiring, driven, read_wiring

HEAD = '<robot name="r">'
PORT, DIRECTION, MOTOR = "port", "direction", "motor"


def joint(name: str, **params: str) -> str:
    given = "".join(f'<param name="{key}">{text}</param>' for key, text in params.items())
    return (
        f'<joint name="{name}" type="continuous"><limit velocity="10" effort="0.1"/></joint>'
        f'<ros2_control><joint name="{name}">{given}<command_interface name="velocity"/></joint>'
        "</ros2_control>"
    )


def read_wirings(text: str) -> list[Wiring]:
    root = parse_xml(text)
    return [read_wiring(root, control) for control in driven(root)]


def robot(*joints: str) -> str:
    return HEAD + "".join(joints) + "</robot>"


def test_the_robot_of_this_repository_names_its_motors():
    wirings = read_wirings(SPIKE.read_text())
    assert [(w.name, w.port, w.direction, w.motor) for w in wirings] == [
        ("left_wheel_joint", "A", -1, "medium angular"),
        ("right_wheel_joint", "B", 1, "medium angular"),
    ]
    for wiring, wheel in zip(wirings, RobotSpec.load().joints, strict=True):
        assert (wiring.name, wiring.port, wiring.max_velocity) == (
            wheel.name,
            wheel.port,
            wheel.max_velocity,
        )


def test_any_number_of_joints_is_read_in_order():
    names = ["arm", "front", "back", "lift"]
    text = robot(*(joint(n, port=p, direction="1") for n, p in zip(names, "DBAC", strict=True)))
    assert [(w.name, w.port, w.motor) for w in read_wirings(text)] == [
        (name, port, None) for name, port in zip(names, "DBAC", strict=True)
    ]


@pytest.mark.parametrize(
    ("params", "complaint"),
    [
        ({PORT: "E", DIRECTION: "1"}, "port is 'E'; valid are A, B, C, D"),
        ({DIRECTION: "1"}, "port.* is missing"),
        ({PORT: "A", DIRECTION: "2"}, "valid are 1 and -1"),
        ({PORT: "A", DIRECTION: "1", MOTOR: "huge"}, "motor is 'huge'; valid are small angular"),
        ({PORT: "A", DIRECTION: "1", MOTOR: " "}, "motor.* is missing"),
    ],
)
def test_what_cannot_be_is_refused_and_what_is_valid_is_named(params, complaint):
    with pytest.raises(SpecError, match=complaint):
        read_wirings(robot(joint("wheel", **params)))
