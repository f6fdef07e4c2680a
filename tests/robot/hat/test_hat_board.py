"""The driver with its motors, on the emulated board: drives as told, and stops in every doubt.

All times are those of the emulated board's own clock.
"""

import math

import numpy as np
import pytest

from benchmarks.hat.bricks import MEDIUM, Bricks
from robot.description.wiring import Wiring
from robot.hat.settings import BuildHatSettings

FORWARD = np.radians([300.0, 300.0])
LARGE, MEDIUM_GREY = 0x31, 0x4B
STOP_S = 0.5


@pytest.fixture
def bricks():
    return driving(Bricks())


def driving(made: Bricks) -> Bricks:
    made.until(made.ready)
    made.wanted = FORWARD
    made.run(0.6)
    assert np.abs(made.speeds()).min() > 250
    return made


def said(bricks: Bricks) -> str:
    return " ".join(bricks.board.state(bricks.now).faults)


def test_positive_velocities_drive_forward_on_both_sides(bricks):
    assert bricks.speeds() == pytest.approx([-300, 300], rel=0.05)
    assert bricks.board.state(bricks.now).velocities == pytest.approx(FORWARD, rel=0.05)


def test_positions_are_those_of_the_shafts_at_the_stamp(bricks):
    rows = bricks.run(0.5)
    state = bricks.board.state(bricks.now)
    for place, direction in enumerate((-1, 1)):
        turned = np.interp(state.stamp, rows[:, 0], rows[:, 3 + place])
        assert direction * math.degrees(state.positions[place]) == pytest.approx(turned, abs=3)
    assert bricks.now - state.stamp < 0.03


@pytest.mark.parametrize("phase_ms", [1, 5, 9])
@pytest.mark.parametrize("degrees", [100, 250, 500])
def test_a_step_of_speed_is_reached_soon_without_overshoot_and_by_both_at_once(phase_ms, degrees):
    bricks = Bricks(phase_ms=phase_ms)
    bricks.until(bricks.ready)
    bricks.wanted = np.zeros(2)
    bricks.run(0.2)
    bricks.wanted = np.radians([degrees, degrees])
    rows = bricks.run(1.2)
    speeds = np.abs(rows[:, 1:3])
    begins = [rows[np.argmax(column > 5), 0] for column in speeds.T]
    assert abs(begins[0] - begins[1]) <= 0.010
    assert speeds.max() <= 1.05 * degrees
    late = speeds[rows[:, 0] > rows[0, 0] + 0.3]
    assert late.min() > 0.95 * degrees


def test_it_stands_still_within_two_degrees_after_a_stop(bricks):
    bricks.wanted = np.zeros(2)
    bricks.until(bricks.stands, STOP_S)
    rows = bricks.run(2.0)
    assert np.ptp(rows[:, 3:], axis=0).max() <= 2
    assert bricks.stands()


def test_a_wheel_that_was_held_back_catches_up_so_that_the_robot_keeps_its_heading(bricks):
    before = np.array([bricks.motor(port).angle for port in (0, 1)])
    bricks.motor(0).load = 0.02
    bricks.run(0.5)
    bricks.motor(0).load = 0.0
    bricks.run(1.5)
    turned = np.array([bricks.motor(port).angle for port in (0, 1)]) - before
    assert turned[0] + turned[1] == pytest.approx(0, abs=6)


def a_program_that_hangs(bricks):
    bricks.wanted = None


def a_driver_that_is_killed(bricks):
    bricks.alive = False


def a_cut_serial_line(bricks):
    bricks.emulated.silent = True


def a_motor_cable_pulled_out(bricks):
    bricks.emulated.unplug(0)


def a_blocked_wheel(bricks):
    bricks.motor(1).stalled = True


def a_motor_power_fault(bricks):
    bricks.emulated.power.motor_fault = True


def a_port_power_fault(bricks):
    bricks.emulated.power.port_fault = True


def a_low_supply(bricks):
    bricks.emulated.supply_v = 5.6


def a_reset_of_the_board(bricks):
    bricks.emulated.reset()


@pytest.mark.parametrize(
    "trouble",
    [
        a_program_that_hangs,
        a_driver_that_is_killed,
        a_cut_serial_line,
        a_motor_cable_pulled_out,
        a_blocked_wheel,
        a_motor_power_fault,
        a_port_power_fault,
        a_low_supply,
        a_reset_of_the_board,
    ],
)
@pytest.mark.parametrize("degrees", [60, 300, 700])
def test_the_motors_stop_within_half_a_second(trouble, degrees):
    bricks = Bricks()
    bricks.until(bricks.ready)
    bricks.wanted = np.radians([degrees, degrees])
    bricks.run(0.7)
    trouble(bricks)
    bricks.until(bricks.stands, STOP_S)
    if trouble is not a_blocked_wheel:  # after a second it tries again
        assert np.abs(bricks.run(1.0)[:, 1:3]).max() < 5


@pytest.mark.parametrize("port", [0, 1])
def test_a_motor_that_is_plugged_in_again_drives_on_with_its_settings_and_its_position(port):
    bricks = driving(Bricks())
    bricks.emulated.unplug(port)
    bricks.run(1.0)
    assert f"port {'AB'[port]}" in said(bricks)
    assert "push its plug in" in said(bricks)
    assert not bricks.board.command(FORWARD, bricks.now).any()
    before = bricks.board.state(bricks.now).positions
    bricks.emulated.plug(port, bricks.devices[port])
    bricks.wanted = np.zeros(2)
    bricks.until(bricks.ready)
    assert bricks.board.state(bricks.now).positions == pytest.approx(before, abs=math.radians(3))
    bricks.wanted = np.radians([700.0, 700.0])
    bricks.run(0.8)
    assert np.abs(bricks.speeds()).min() > 650, "the limit of 0.1 is lifted again"


def test_another_motor_than_the_description_names_is_refused_by_name():
    bricks = Bricks(types=(MEDIUM_GREY, LARGE))
    bricks.wanted = FORWARD
    bricks.run(2.0)
    assert said(bricks) == (
        "On port B (right_wheel_joint) is a large angular motor (45602); "
        "there should be a medium angular motor."
    )
    assert bricks.stands()


@pytest.mark.parametrize("gap", [0.15, 0.25, 0.29])
@pytest.mark.parametrize("waiting", [0, 20, 4096])
def test_a_program_that_stood_still_takes_no_wheel_for_blocked(bricks, gap, waiting):
    """Of what the board said meanwhile, the first bytes wait for the program."""
    heard = bricks.emulated.advance(gap)[:waiting]
    bricks.board.command(FORWARD, bricks.now)
    bricks.emulated.receive(bricks.board.receive(heard, bricks.now))
    bricks.emulated.receive(bricks.board.tick(bricks.now))
    for _ in range(100):
        bricks.run(0.01)
        assert "does not turn" not in said(bricks)
    assert np.abs(bricks.speeds()).min() > 250


@pytest.mark.parametrize("gap", [0.15, 0.25, 0.29])
def test_a_board_that_stood_still_has_no_blocked_wheel(bricks, gap):
    """As the emulated one does on a busy computer: the program goes on, and hears nothing."""
    bricks.wanted = np.zeros(2)
    bricks.run(0.5)
    for tick in range(round(100 * gap)):
        bricks.board.command(FORWARD, bricks.now + 0.01 * tick)
        bricks.board.tick(bricks.now + 0.01 * tick)
        assert "does not turn" not in said(bricks)


def test_a_blocked_wheel_is_told_and_tried_again_when_it_is_free(bricks):
    bricks.motor(1).stalled = True
    bricks.until(lambda: bool(said(bricks)), 0.4)
    assert said(bricks).startswith("The motor on port B (right_wheel_joint) does not turn")
    bricks.motor(1).stalled = False
    bricks.until(bricks.ready, 2.0)
    bricks.run(0.6)
    assert np.abs(bricks.speeds()).min() > 250


def test_a_fault_that_is_over_lets_it_drive_on(bricks):
    bricks.emulated.power.motor_fault = True
    bricks.run(1.5)
    assert "motor power fault" in said(bricks)
    bricks.emulated.power.motor_fault = False
    bricks.until(bricks.ready, 6.0)


def test_a_supply_must_rise_well_above_the_limit_before_it_is_good_again(bricks):
    for volts, ready in ((5.9, False), (6.1, False), (6.5, True)):
        bricks.emulated.supply_v = volts
        bricks.run(0.5)
        assert bricks.ready() == ready, volts


def test_a_board_that_is_reset_is_started_again_and_drives_on(bricks):
    bricks.emulated.reset()
    bricks.run(1.0)
    assert not bricks.ready()
    bricks.until(bricks.ready, 30.0)
    bricks.run(0.6)
    assert np.abs(bricks.speeds()).min() > 250


@pytest.mark.parametrize("kind", ["garble", "garble_in", "loss"])
def test_a_noisy_wire_costs_no_more_than_a_moment(bricks, kind):
    """A byte in 500 is wrong on the way from the board or to it, or lost on the way to it."""
    setattr(bricks.emulated, kind, 0.002)
    rows = bricks.run(10.0)
    speeds = np.abs(rows[:, 1:3])
    assert np.median(speeds) == pytest.approx(300, rel=0.02)
    assert (np.abs(speeds - 300) < 30).mean() > 0.9
    setattr(bricks.emulated, kind, 0.0)
    bricks.until(bricks.ready, 5.0)
    bricks.run(0.8)
    assert bricks.speeds() == pytest.approx([-300, 300], rel=0.05)


def test_two_motors_at_a_hundred_reports_take_half_of_the_wire_at_most():
    bricks = driving(Bricks())
    sent, received = bricks.sent, bricks.received
    rng = np.random.default_rng(0)
    for _ in range(20):
        bricks.wanted = FORWARD * rng.uniform(-1, 1)
        bricks.run(0.25)
    assert (bricks.sent - sent) / 5.0 <= 0.5 * 11520
    assert (bricks.received - received) / 5.0 <= 0.5 * 11520


def test_four_joints_of_another_robot_turn_each_as_told():
    """An arm, two wheels and a lift, on ports in any order."""
    ports, directions = "CADB", (1, -1, 1, -1)
    wirings = [
        Wiring(name, port, direction, None, 12.0)
        for name, port, direction in zip(
            ("arm", "left", "right", "lift"), ports, directions, strict=True
        )
    ]
    bricks = Bricks(types=(LARGE, MEDIUM, MEDIUM_GREY, MEDIUM), wirings=wirings)
    bricks.until(bricks.ready)
    bricks.wanted = np.radians([100.0, 200.0, 300.0, -400.0])
    bricks.run(1.0)
    shafts = [bricks.motor("ABCD".index(port)).speed for port in ports]
    assert shafts == pytest.approx([100, -200, 300, 400], rel=0.05)
    assert bricks.board.state(bricks.now).velocities == pytest.approx(bricks.wanted, rel=0.05)
    bricks.emulated.unplug("ABCD".index("D"))
    bricks.until(bricks.stands, STOP_S)
    assert "port D (right)" in said(bricks)


def test_a_limit_of_power_is_kept():
    bricks = Bricks(settings=BuildHatSettings(power_limit=0.3))
    bricks.until(bricks.ready)
    bricks.wanted = np.radians([700.0, 700.0])
    bricks.run(1.0)
    assert np.abs(bricks.speeds()).max() < 300


def test_without_a_kind_in_the_description_any_motor_with_an_encoder_will_do():
    wirings = [Wiring("wheel", "A", 1, None, 12.0), Wiring("arm", "B", 1, None, 12.0)]
    bricks = Bricks(types=(LARGE, LARGE), wirings=wirings)
    bricks.until(bricks.ready)
    bricks.board.receive(b"P1: disconnected\r\nP1: connected to passive ID 2\r\n", bricks.now)
    assert said(bricks) == (
        "On port B (arm) is a train motor (88011): it has no encoder; "
        "there should be a motor with an encoder."
    )
