"""What a real robot says of itself reaches the page, and the program stands meanwhile."""

import threading

import cv2
import numpy as np
import pytest

from app.engine.build import build_program
from app.messages.driving_commands import DriveCommand
from app.settings.config import Config
from benchmarks.hat.bricks import Bricks
from robot.cameras.choice import open_camera
from robot.cameras.settings import CameraSourceSettings

pytestmark = pytest.mark.slow

DRIVE = DriveCommand(type="drive", v=0.15, omega=0.0)


@pytest.fixture
def bricks():
    return Bricks()


@pytest.fixture
def engine(bricks, tmp_path):
    cv2.imwrite(str(tmp_path / "floor.png"), np.full((480, 640), 200, np.uint8))
    camera = open_camera(
        bricks.spec.lens, CameraSourceSettings(source=str(tmp_path)), lambda: bricks.now
    )
    made = build_program(Config(robot="kinematic"), robot=bricks.robot(camera)).engine
    while not made.step().connected:
        pass
    yield made
    made.controls.robot.close()


def driven(engine, seconds):
    shown = [engine.step()]
    while shown[-1].stamp < shown[0].stamp + seconds:
        engine.commands.put(DRIVE)
        shown.append(engine.step())
    return shown


def test_it_drives_through_the_serial_line(engine):
    shown = driven(engine, 1.5)
    assert shown[-1].twist.v == pytest.approx(0.15, rel=0.05)
    assert shown[-1].odometry.x > 0.1
    assert shown[-1].battery_v == pytest.approx(8.0, abs=0.05)
    assert shown[-1].problems.present == ()


def test_a_motor_unplugged_is_told_with_its_port_and_the_robot_stands_until_it_is_back(
    engine, bricks
):
    driven(engine, 1.0)
    bricks.emulated.unplug(1)
    gone = driven(engine, 1.0)[-1]
    assert not gone.connected
    assert gone.mode == "idle"
    assert (gone.twist.v, gone.twist.omega) == (0, 0)
    assert any("port B (right_wheel_joint)" in problem for problem in gone.problems.present)
    assert any("port B" in entry.message for entry in gone.problems.record)
    bricks.emulated.plug(1, bricks.devices[1])
    while not engine.step().connected:
        pass
    back = driven(engine, 1.0)[-1]
    assert back.problems.present == ()
    assert back.twist.v == pytest.approx(0.15, rel=0.05)


def test_after_a_fault_nothing_moves_by_itself(engine, bricks):
    driven(engine, 1.0)
    bricks.emulated.power.motor_fault = True
    driven(engine, 0.3)
    bricks.emulated.power.motor_fault = False
    shown = [engine.step() for _ in range(400)]
    assert shown[-1].connected
    assert shown[-1].mode == "idle"
    assert bricks.stands()


def test_an_engine_that_fails_stops_the_motors(engine, bricks, monkeypatch, caplog):
    driven(engine, 1.0)
    monkeypatch.setattr(engine, "_localize", lambda reading: 1 / 0)
    begin = bricks.now
    engine.run(threading.Event())
    assert engine.failure == "The robot stopped: ZeroDivisionError: division by zero"
    assert "division by zero" in caplog.text
    bricks.until(bricks.stands, 0.5 - (bricks.now - begin))


def test_stamps_rise_while_the_board_is_away(engine, bricks):
    stamps = [snapshot.stamp for snapshot in driven(engine, 0.5)]
    bricks.emulated.reset()
    stamps += [engine.step().stamp for _ in range(200)]
    assert np.all(np.diff(stamps) > 0)
    assert stamps[-1] - stamps[0] > 4.0
