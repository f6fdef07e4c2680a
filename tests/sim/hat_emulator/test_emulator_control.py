"""Hands on the emulated board, and the lines that move them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import closing

import pytest
from emulator_bench import A, Bench
from hypothesis import given
from hypothesis import strategies as st
from simulators import require_engine

from robot.description.spec import RobotSpec
from sim.engines import physics_world
from sim.hat_emulator.surroundings import RobotOnField, Table


@pytest.fixture
def bench() -> Iterator[Bench]:
    with closing(Bench()) as made:
        yield made


def test_unplugged_and_plugged_again_it_is_the_same_motor(bench: Bench) -> None:
    assert bench.ask("unplug a") == "ok"
    assert "P0: timeout during data phase: disconnecting" in bench.run(1.0)
    assert bench.ask("unplug A") == "error: nothing is plugged in at A"
    assert bench.ask("plug A") == "ok"
    assert "P0: connected to active ID 30" in bench.run(3.5)


def test_another_motor_can_be_plugged_in(bench: Bench) -> None:
    assert bench.ask("plug C large-grey") == "ok"
    assert "P2: connected to active ID 4C" in bench.run(3.5)
    assert "no motor is called 'huge'; valid are medium, large" in bench.ask("plug C huge")
    assert "nothing was unplugged at D; say what, of medium" in bench.ask("plug D")


def test_a_slow_device_takes_its_time(bench: Bench) -> None:
    bench.ask("unplug A")
    assert bench.ask("slow A 5") == "ok"
    bench.run(1.0)
    bench.ask("plug A")
    assert "P0: connected" not in bench.run(4.5)
    assert "P0: connected" in bench.run(1.5)
    assert bench.ask("slow D 1") == "error: nothing is plugged in at D"


def test_a_blocked_shaft_stands_and_a_loaded_one_is_slower(bench: Bench) -> None:
    drive = "port 0;plimit 1;pwm;set .5\r"
    bench.say(drive, 1.0)
    free = bench.around.plants.plant(A).speed
    assert bench.ask("load A 0.02") == "ok"
    bench.run(0.5)
    assert 0 < bench.around.plants.plant(A).speed < 0.8 * free
    assert bench.ask("stall A") == "ok"
    bench.run(0.1)
    assert bench.around.plants.plant(A).speed == 0
    assert bench.ask("free A") == "ok"
    bench.run(0.5)
    assert bench.around.plants.plant(A).speed == pytest.approx(free, rel=0.01)
    assert bench.ask("duty") == f"{127 / 255:.4f} 0.0000 0.0000 0.0000"


def test_a_mute_motor_times_out(bench: Bench) -> None:
    assert bench.ask("mute B on") == "ok"
    assert "P1: timeout during data phase" in bench.run(1.0)
    assert bench.ask("mute B off") == "ok"
    assert "P1: connected" in bench.run(3.5)


def test_a_start_of_a_device_can_fail_and_so_can_its_data(bench: Bench) -> None:
    assert bench.ask("setup A checksum") == "ok"
    assert bench.ask("errors A") == "ok"
    told = bench.run(1.5)
    assert "P0: too many errors" in told
    assert "P0: checksum error: disconnecting" in told
    assert "valid are framing, checksum, silence" in bench.ask("setup A magic")


def test_faults_come_and_go(bench: Bench) -> None:
    assert bench.ask("fault motor on") == "ok"
    assert "Motor power fault" in bench.run(0.5)
    assert bench.ask("fault motor off") == "ok"
    assert bench.ask("fault port on") == "ok"
    assert "Port power fault" in bench.run(0.5)
    assert "valid are motor, port" in bench.ask("fault other on")
    assert "valid are on, off" in bench.ask("fault port maybe")


def test_the_supply_is_what_it_is_set_to(bench: Bench) -> None:
    assert bench.ask("supply 6.5") == "ok"
    assert bench.say("vin\r") in ("\r\n6.50 V\r\n", "\r\n6.49 V\r\n")
    assert bench.around.plants.supply_v == 6.5


def test_without_a_robot_nothing_can_be_placed(bench: Bench) -> None:
    for line in ("place 0 0 0", "truth"):
        assert bench.ask(line) == "error: there is no robot: the motors turn freely (--world free)"


def test_a_robot_is_placed_and_drives_by_its_port() -> None:
    require_engine()
    spec = RobotSpec.load()
    bench = Bench(RobotOnField(physics_world("auto", spec), spec))
    assert bench.ask("place 0.2 -0.1 1.5") == "ok"
    assert bench.ask("truth") == "0.200000 -0.100000 1.500000"
    left, right = (0.4 * joint.direction for joint in spec.joints)
    bench.say(f"plimit 1;port 0;pwm;set {left};port 1;pwm;set {right}\r", 0.5)
    _, y, theta = (float(word) for word in bench.ask("truth").split())
    assert y > -0.1 + 0.03
    assert theta == pytest.approx(1.5, abs=0.01)
    bench.close()


@pytest.mark.parametrize(
    ("line", "valid"),
    [
        ("", "valid are unplug, plug"),
        ("jump", "valid are unplug, plug"),
        ("unplug", "valid is: unplug PORT"),
        ("unplug E", "valid are A, B, C, D"),
        ("load A much", "valid is a number from -10 to 10"),
        ("load A nan", "valid is a number from -10 to 10"),
        ("supply -1", "valid is a number from 0 to 18"),
        ("silent loudly", "valid are on, off"),
        ("place 1 2", "valid is: place X Y THETA"),
        ("place 1 2 inf", "valid is a number"),
        ("truth now", "valid is: truth"),
    ],
)
def test_a_wrong_line_names_what_is_valid(bench: Bench, line: str, valid: str) -> None:
    answer = bench.ask(line)
    assert answer.startswith("error: ")
    assert valid in answer


def test_help_names_every_command_and_state_every_port(bench: Bench) -> None:
    assert bench.ask("help").count("|") >= 21
    assert re.fullmatch(
        r"now 0\.000; supply 8\.00; firmware; A 30 0\.0 0\.0; B 30 0\.0 0\.0; "
        r"C - 0\.0 0\.0; D - 0\.0 0\.0; lost 0\.000",
        bench.ask("state"),
    )


WORDS = (
    "unplug plug slow stall free load mute setup errors fault supply silent garble garble-in lose "
    "late say firmware reset place truth duty state help A B C D E on off motor port 0 1 -1 nan "
    "1e9 silence"
)
WORD = st.sampled_from(WORDS.split()) | st.text(max_size=3)


@given(st.lists(st.lists(WORD, max_size=4), max_size=12))
def test_no_line_does_more_than_answer_with_a_line(lines: list[list[str]]) -> None:
    bench = Bench(Table({}))
    for words in lines:
        answer = bench.ask(" ".join(words))
        assert answer
        assert "\n" not in answer
    bench.close()
