"""Hands on the emulated board, the lines that move them, and the loop that keeps it to a clock."""

from __future__ import annotations

import os
import re
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot.description.spec import RobotSpec
from robot.hat.protocol.decoder import Decoder
from robot.hat.protocol.events import BusError, Event, QueueOverrun, Supply
from sim.bullet import BulletMissingError, BulletWorld, load_pybullet
from sim.hat.devices.motor_figures import figures_named
from sim.hat_emulator.control import Control
from sim.hat_emulator.emulator import Beginning, Emulator
from sim.hat_emulator.line_server import LONGEST_LINE, Lines, LineServer, TypedLines
from sim.hat_emulator.pseudo_terminal import PseudoTerminal
from sim.hat_emulator.real_time import LONGEST_LAG
from sim.hat_emulator.surroundings import RobotOnField, Surroundings, Table

MEDIUM = figures_named("medium")
A, B, C, D = range(4)
START = 50.0


class Bench:
    """An emulator on a clock that the test moves, with a program at its port."""

    def __init__(self, around: Surroundings, beginning: Beginning | None = None) -> None:
        self.now = START
        self.around = around
        self.terminal = PseudoTerminal()
        motors = {A: MEDIUM, B: MEDIUM}
        self.emulator = Emulator(around, motors, self.terminal, beginning, self.clock)
        self.control = Control(self.emulator)
        self.port = os.open(self.terminal.device, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)

    def clock(self) -> float:
        return self.now

    def ask(self, line: str) -> str:
        return self.control.answer(line)

    def send(self, text: str) -> None:
        os.write(self.port, text.encode())

    def run(self, seconds: float) -> str:
        """What the board says meanwhile."""
        heard = b""
        for _ in range(round(seconds / 0.002)):
            self.emulator.loop.turn(0)
            self.now += 0.002
            try:
                heard += os.read(self.port, 65536)
            except BlockingIOError:
                continue
        return heard.decode("utf-8", "replace")

    def say(self, text: str, seconds: float = 0.1) -> str:
        self.send(text)
        return self.run(seconds)

    def close(self) -> None:
        os.close(self.port)
        self.emulator.loop.close()
        self.terminal.close()
        self.around.close()


@pytest.fixture
def bench() -> Iterator[Bench]:
    made = Bench(Table({A: MEDIUM, B: MEDIUM}))
    yield made
    made.close()


def test_the_board_answers_at_the_port(bench: Bench) -> None:
    assert bench.say("vin\r") == "\r\n8.00 V\r\n"


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


def test_a_silent_board_neither_hears_nor_speaks(bench: Bench) -> None:
    assert bench.ask("silent on") == "ok"
    assert bench.say("port 0;pwm;set .1\rvin\r") == ""
    assert bench.ask("silent off") == "ok"
    assert bench.run(0.1) == ""
    assert bench.ask("duty").startswith("0.0000")


def test_noise_on_the_wire_changes_what_is_heard(bench: Bench) -> None:
    clean = bench.say("list\r", 0.5)
    assert bench.ask("garble 0.05") == "ok"
    assert bench.say("list\r", 0.5) != clean
    assert bench.ask("garble 2").startswith("error")


def test_noise_on_the_way_in_changes_what_the_board_does(bench: Bench) -> None:
    assert bench.ask("garble-in 1") == "ok"
    assert "V" not in bench.say("vin\r")
    assert bench.ask("garble-in 0") == "ok"
    bench.say("\r")
    assert bench.say("vin\r") == "\r\n8.00 V\r\n"
    assert bench.ask("garble-in 2").startswith("error")


def test_bytes_are_lost_on_the_way_in(bench: Bench) -> None:
    assert bench.ask("lose 1") == "ok"
    assert bench.say("vin\r") == ""
    assert bench.ask("lose 0") == "ok"
    assert bench.say("vin\r") == "\r\n8.00 V\r\n"


@pytest.mark.parametrize(
    ("text", "event"),
    [
        ("MQ overrun!", QueueOverrun()),
        ("<I²C bus timeout>", BusError("<I²C bus timeout>")),
        ("Attempting reset of I²C bus", BusError("Attempting reset of I²C bus")),
    ],
)
def test_the_board_says_out_of_turn_what_it_is_told_to(
    bench: Bench, text: str, event: Event
) -> None:
    assert bench.ask(f"say {text}") == "ok"
    heard = Decoder().feed(bench.say("vin\r").encode())
    assert event in heard
    assert Supply(8.0) in heard
    assert bench.ask("say") == "error: valid is: say TEXT"


def test_an_error_of_the_inner_bus_ends_no_line(bench: Bench) -> None:
    bench.ask("say <generic I²C bus error>")
    bench.ask("say MQ overrun!")
    assert bench.run(0.1) == "<generic I²C bus error>MQ overrun!\r\n"


def test_a_late_pass_is_told(bench: Bench) -> None:
    assert bench.ask("late 30") == "ok"
    assert re.search(r"deltat=[0-9A-F]{8}", bench.run(0.2))


def test_another_firmware_runs_with_the_same_devices_and_the_motors_stopped(bench: Bench) -> None:
    bench.say("port 0;plimit 1;pwm;set 1\r", 1.0)
    assert bench.around.plants.plant(A).speed > 500
    assert bench.ask("firmware 1670596313") == "ok"
    assert "Firmware version: 1670596313" in bench.say("version\r")
    assert "P0: connected to active ID 30" in bench.say("list\r", 0.5)
    bench.run(1.0)
    assert bench.around.plants.plant(A).speed == 0
    assert bench.emulator.wall(bench.now - START) == pytest.approx(bench.now, abs=0.003)


@pytest.mark.parametrize("line", ["reset", "bootloader"])
def test_a_reset_stops_the_motors_and_ends_in_the_bootloader(bench: Bench, line: str) -> None:
    bench.say("port 0;plimit 1;pwm;set 1\r", 0.5)
    assert bench.ask(line) == "ok"
    assert bench.ask("duty") == "coast coast coast coast"
    assert "bootloader" in bench.ask("state")
    assert "Type help" in bench.run(0.1)
    assert "BuildHAT bootloader version" in bench.say("version\r")


def test_it_can_start_in_the_bootloader_or_with_another_firmware() -> None:
    for beginning, says in (
        (Beginning(warm=False), "BuildHAT bootloader version"),
        (Beginning(version=1670596313), "Firmware version: 1670596313"),
    ):
        bench = Bench(Table({}), beginning)
        bench.run(0.1)
        assert says in bench.say("version\r")
        bench.close()


def test_the_seed_is_where_the_marks_are() -> None:
    def marks(seed: int) -> str:
        bench = Bench(Table({}), Beginning(seed=seed))
        told = bench.say("port 0;select 3\rport 1;select 3\r", 0.3)
        bench.close()
        return str(sorted(set(re.findall(r"P\dM3: \S+", told))))

    assert marks(1) == marks(1) != marks(2)


def test_without_a_robot_nothing_can_be_placed(bench: Bench) -> None:
    for line in ("place 0 0 0", "truth"):
        assert bench.ask(line) == "error: there is no robot: the motors turn freely (--world free)"


def test_a_robot_is_placed_and_drives_by_its_port() -> None:
    try:
        load_pybullet()
    except BulletMissingError:
        pytest.skip("pybullet is not installed")
    spec = RobotSpec.load()
    bench = Bench(RobotOnField(BulletWorld(spec), spec))
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


@given(
    st.lists(
        st.lists(st.sampled_from(WORDS.split()) | st.text(max_size=3), max_size=4), max_size=12
    )
)
def test_no_line_does_more_than_answer_with_a_line(lines: list[list[str]]) -> None:
    bench = Bench(Table({}))
    for words in lines:
        answer = bench.ask(" ".join(words))
        assert answer
        assert "\n" not in answer
    bench.close()


def test_what_was_lost_in_a_stall_never_was(bench: Bench) -> None:
    bench.run(0.1)
    before = bench.emulator.board.now
    bench.now += 5
    bench.emulator.loop.turn(0)
    assert bench.emulator.board.now - before == pytest.approx(LONGEST_LAG, abs=0.0011)
    assert bench.emulator.loop.lost == pytest.approx(5 - LONGEST_LAG, abs=0.0031)
    zero = bench.emulator.loop.wall(bench.emulator.board.now)
    assert zero == pytest.approx(bench.now, abs=0.0011)
    bench.run(1.0)
    assert bench.emulator.loop.lost == pytest.approx(5 - LONGEST_LAG, abs=0.0031)


def test_a_program_that_reads_nothing_stops_nothing(bench: Bench) -> None:
    bench.send("port 0;select 1;selrate 1\r")
    for _ in range(5000):
        bench.emulator.loop.turn(0)
        bench.now += 0.002
    assert bench.emulator.board.now == pytest.approx(10, abs=0.01)


def test_lines_are_put_together_from_pieces() -> None:
    lines = Lines(lambda text: f"<{text}>")
    assert lines.feed(b"one\r\ntw") == b"<one>\n"
    assert lines.feed(b"o\n\n  \nthree\n") == b"<two>\n<three>\n"
    with pytest.raises(ValueError, match="longer than"):
        lines.feed(b"x" * (LONGEST_LINE + 1))


def connect(path: Path) -> socket.socket:
    connection = socket.socket(socket.AF_UNIX)
    connection.settimeout(1)
    connection.connect(str(path))
    return connection


def gone(connection: socket.socket) -> bool:
    try:
        return connection.recv(100) == b""
    except ConnectionResetError:
        return True


def test_programs_are_answered_through_the_socket(bench: Bench, tmp_path: Path) -> None:
    path = tmp_path / "hands"
    server = LineServer(path, bench.ask, bench.emulator.loop)
    with connect(path) as one, connect(path) as other:
        one.sendall(b"supply 7")
        other.sendall(b"stall A\nduty\n")
        bench.run(0.01)
        one.sendall(b".2\n")
        bench.run(0.01)
        assert one.recv(100) == b"ok\n"
        assert other.recv(100) == b"ok\n0.0000 0.0000 0.0000 0.0000\n"
        other.sendall(b"x" * (LONGEST_LINE + 100))
        bench.run(0.01)
        assert gone(other)
    assert bench.emulator.board.supply_v == 7.2
    bench.run(0.01)
    server.close()
    server.close()
    assert not path.exists()


def test_the_socket_closes_on_those_who_still_talk(bench: Bench, tmp_path: Path) -> None:
    server = LineServer(tmp_path / "hands", bench.ask, bench.emulator.loop)
    with connect(tmp_path / "hands") as one:
        bench.run(0.01)
        server.close()
        assert one.recv(100) == b""
    assert bench.say("vin\r") == "\r\n8.00 V\r\n"


def test_typed_lines_are_answered_until_nobody_types_any_more(bench: Bench) -> None:
    source, typing = os.pipe()
    said: list[str] = []
    TypedLines(source, bench.ask, bench.emulator.loop, said.append)
    os.write(typing, b"truth\nstall B\n")
    bench.run(0.01)
    assert len(said) == 1
    assert said[0].splitlines()[1] == "ok"
    os.close(typing)
    bench.run(0.01)
    assert bench.say("vin\r") == "\r\n8.00 V\r\n"
    os.close(source)
