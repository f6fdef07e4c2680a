"""The emulated board among its devices: how it starts, starts again, and keeps to a clock."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import closing

import pytest
from emulator_bench import START, A, Bench

from sim.hat_emulator.emulator import LONGEST_LAG, TURN, InitialState
from sim.hat_emulator.surroundings import Table


@pytest.fixture
def bench() -> Iterator[Bench]:
    with closing(Bench()) as made:
        yield made


def test_the_board_answers_at_the_port(bench: Bench) -> None:
    assert bench.say("vin\r") == "\r\n8.00 V\r\n"


def test_turns_that_end_early_do_not_add_up_to_a_long_wait(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    waits: list[float] = []
    monkeypatch.setattr(bench.emulator.loop, "turn", waits.append)
    bench.emulator.loop.run(lambda: len(waits) == 100)
    assert max(waits) <= TURN + 1e-9


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
        (InitialState(warm=False), "BuildHAT bootloader version"),
        (InitialState(version=1670596313), "Firmware version: 1670596313"),
    ):
        bench = Bench(Table({}), beginning)
        bench.run(0.1)
        assert says in bench.say("version\r")
        bench.close()


def test_the_seed_is_where_the_marks_are() -> None:
    def marks(seed: int) -> str:
        bench = Bench(Table({}), InitialState(seed=seed))
        told = bench.say("port 0;select 3\rport 1;select 3\r", 0.3)
        bench.close()
        return str(sorted(set(re.findall(r"P\dM3: \S+", told))))

    assert marks(1) == marks(1) != marks(2)


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
