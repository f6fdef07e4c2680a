"""What damaged bytes and stalls can do to the motors: next to nothing, and not for long."""

import numpy as np
import pytest

from benchmarks.hat.bricks import Bricks
from robot.hat.protocol import commands
from sim.hat.emulated_board import EmulatedBoard
from sim.hat.lego_motor import LegoMotor
from sim.hat.plants import FreeMotors

STANDING = commands.stop((0, 1))


def damaged(line: bytes) -> list[bytes]:
    """Every loss, doubling and flip of one bit of one byte of a line."""
    found = []
    for place, byte in enumerate(line):
        before, after = line[:place], line[place + 1 :]
        found += [before + after, before + bytes([byte, byte]) + after]
        found += [before + bytes([byte ^ 1 << bit]) + after for bit in range(8)]
    return found


def warm_board() -> tuple[EmulatedBoard, FreeMotors]:
    """Two motors in direct drive with all of the power, standing."""
    plants = FreeMotors()
    board = EmulatedBoard(plants, {port: LegoMotor(0x30, plants.plant(port)) for port in (0, 1)})
    for port in (0, 1):
        board.receive(commands.set_up_motor(port, 0, 1.0))
    board.advance(0.05)
    return board, plants


def test_no_wound_of_the_line_that_is_sent_at_rest_turns_a_wheel():
    board, plants = warm_board()
    for line in damaged(STANDING):
        board.receive(line + b"\r")
        board.advance(0.03)
        assert plants.plant(0).angle == plants.plant(1).angle == 0, line


def test_a_robot_at_rest_sends_that_line():
    bricks = Bricks()
    bricks.until(bricks.ready)
    bricks.wanted = np.zeros(2)
    heard = []
    hear = bricks.emulated.receive
    bricks.emulated.receive = lambda data: (heard.append(data), hear(data))
    bricks.run(1.0)
    lines = {line for data in heard for line in data.split(b"\r") if line}
    assert lines == {STANDING.rstrip(b"\r"), b"vin"}


@pytest.mark.parametrize("closed", ["pid 0 0 0 s1 1 0 0.003 0.01 0 100 0.01;set 20", "pwm;set .5"])
def test_no_lost_byte_of_the_farewell_leaves_a_motor_turning(closed):
    farewell = Bricks().board.farewell()
    for place in range(len(farewell)):
        board, plants = warm_board()
        board.receive(f"port 0;combi 0 1 0 2 0 3 0;select 0;{closed}\r".encode())
        board.advance(0.3)
        board.receive(farewell[:place] + farewell[place + 1 :])
        board.advance(0.4)
        assert abs(plants.plant(0).speed) < 1, farewell[:place]


def test_nothing_is_lost_of_the_way_when_the_program_comes_late_to_read():
    bricks = Bricks()
    bricks.until(bricks.ready)
    bricks.wanted = np.radians([800.0, 800.0])
    rng = np.random.default_rng(0)
    for _ in range(20):
        bricks.run(0.4)
        bricks.alive = False
        late = b"".join(bricks.emulated.advance(0.001) for _ in range(rng.integers(20, 150)))
        bricks.alive = True
        bricks.board.receive(late, bricks.now)
    bricks.wanted = np.zeros(2)
    bricks.run(1.0)
    told = np.degrees(bricks.board.state(bricks.now).positions) * (-1, 1)
    assert told == pytest.approx([bricks.motor(port).angle for port in (0, 1)], abs=3)


@pytest.mark.parametrize(
    ("line", "instead"),
    [
        (b"P1: established serial communication with active ID 30", b""),
        (b"ID 30", b"ID 31"),
        (b"ID 30", b"ID 3"),
    ],
)
def test_a_motor_whose_arrival_was_not_heard_is_found_all_the_same(line, instead):
    bricks = Bricks()
    bricks.until(bricks.ready)
    bricks.emulated.unplug(1)
    bricks.run(1.0)
    hear = bricks.board.receive
    bricks.board.receive = lambda data, now: hear(b"".join(held(data)), now)
    kept = bytearray()

    def held(data):
        """Whole lines, so that a wound in one of them can be made."""
        kept.extend(data)
        *lines, rest = bytes(kept).split(b"\n")
        kept[:] = rest
        for one in lines:
            yield (one.replace(line, instead) if b"P1: " in one else one) + b"\n"

    bricks.emulated.plug(1, bricks.devices[1])
    bricks.run(3.0)
    bricks.board.receive = hear
    bricks.until(bricks.ready, 6.0)


def test_a_stray_line_that_a_motor_is_gone_costs_seconds_and_no_more():
    bricks = Bricks()
    bricks.until(bricks.ready)
    bricks.board.receive(b"P1: disconnected\r\n", bricks.now)
    assert not bricks.ready()
    bricks.until(bricks.ready, 5.0)


def test_a_board_that_hears_nothing_is_no_board_although_it_speaks():
    bricks = Bricks()
    bricks.until(bricks.ready)
    bricks.emulated.receive = lambda data: None
    bricks.emulated.supply_v = 5.0
    bricks.until(lambda: not bricks.ready(), 1.0)
    bricks.run(5.0)
    state = bricks.board.state(bricks.now)
    assert state.supply_v is None
    assert state.faults


def test_one_garbled_digit_of_the_version_does_not_cost_a_reset():
    bricks = Bricks()
    bricks.emulated.advance(0.001)
    whole = b"".join(bricks.emulated.advance(0.001) for _ in range(40))
    assert b"1737564117" in whole
    wounded = whole.replace(b"1737564117", b"1737564116")
    bricks.emulated.receive(bricks.board.receive(wounded, bricks.now))
    assert bricks.until(bricks.ready, 3.0) < 2.0
    assert not bricks.emulated.in_bootloader


def test_a_supply_that_no_board_could_live_on_is_a_garbled_one():
    bricks = Bricks()
    bricks.until(bricks.ready)
    bricks.run(0.2)
    for told in (b"0.10 V", b"77.98 V"):
        bricks.board.receive(told + b"\r\n", bricks.now)
        assert bricks.board.state(bricks.now).supply_v == pytest.approx(8.0)


@pytest.mark.slow
def test_few_wounds_of_the_last_line_before_a_death_let_a_wheel_turn_on():
    """docs/robot.md tells how few; while the program lives its next line cures each of them."""
    line = commands.pulses({0: -0.523, 1: 0.502}, 0.2)
    wounds = damaged(line)
    turning = 0
    for wound in wounds:
        board, plants = warm_board()
        board.receive(wound)
        board.advance(0.7)
        turning += max(abs(plants.plant(port).speed) for port in (0, 1)) > 1
    assert turning <= 0.03 * len(wounds), f"{turning} of {len(wounds)}"
    cured, plants = warm_board()
    for wound in wounds:
        cured.receive(wound + b"\r")
        cured.advance(0.02)
        cured.receive(commands.stop((0, 1)))
        cured.advance(0.3)
        assert max(abs(plants.plant(port).speed) for port in (0, 1)) < 1, wound


def test_a_board_that_restarts_in_the_middle_of_an_upload_is_started_all_the_same():
    """It is deaf for as long as 10 ms for each byte that came meanwhile, so it is reset again."""
    bricks = Bricks(warm=False)
    bricks.run(3.0)
    bricks.emulated.reset()
    assert bricks.until(bricks.ready, 60) < 40
