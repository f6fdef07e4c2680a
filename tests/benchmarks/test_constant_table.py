"""The table of constants: what verdict figures come to, and what a page and a list keep."""

from __future__ import annotations

import signal
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from benchmarks.changed_constant import Constant
from benchmarks.constant_runs import Outcome, Try, trials_of
from benchmarks.constant_table import (
    Measuring,
    Row,
    listed_constants,
    move_listed,
    read_rows,
    write_page,
)

SPEED = Constant.of("route.SPEED")


def measured(figure: Callable[[str, int], float | None], name: str = "off [mm]") -> Row | None:
    """The row of a constant, by what a run's figure is with a value and random numbers.

    Without a figure a run fails. Its results are as usual if its figure is.
    """

    def outcome(run: Try) -> Outcome:
        value = figure(run.value, run.other_numbers)
        if value is None:
            raise subprocess.CalledProcessError(1, [], stderr=b"Traceback\nValueError: no tape\n")
        return {name: value, "each": [value]}

    return Measuring(Try("trials", "drives"), outcome).row(SPEED)


def by_chance(numbers: int) -> float:
    """Of five runs: their standard deviation is 0.16."""
    return 10 + 0.1 * (numbers // 1000 % 3 - 1) * 2


def test_what_differs_by_less_than_chance_changes_nothing() -> None:
    row = measured(lambda value, numbers: by_chance(numbers) + (0.3 if value else 0))
    assert row is not None
    assert row.verdict == "half and twice: nothing beyond chance"
    assert row.measured == "off [mm]: 10.1, 9.8, 10.1 (by chance 0.669)"
    assert (row.file, row.constant, row.value) == ("robot/driving/route.py", "SPEED", "0.12")
    assert row.sentence.startswith("Highest speed")


@pytest.mark.parametrize(
    ("name", "verdict"),
    [
        ("off [mm]", "half is worse; twice is better"),
        ("right [%]", "half is better; twice is worse"),
    ],
)
def test_half_and_twice_are_better_or_worse_by_the_figure(name: str, verdict: str) -> None:
    changes = {"*0.5": 5.0, "*2": -5.0}
    row = measured(lambda value, numbers: by_chance(numbers) + changes.get(value, 0), name)
    assert row is not None and row.verdict == verdict


def test_what_is_better_with_the_same_random_numbers_only_is_not_better() -> None:
    row = measured(lambda value, numbers: 5.0 if value and not numbers else by_chance(numbers))
    assert row is not None
    assert "is better" not in row.verdict and "only with these random numbers" in row.verdict


def test_a_run_that_fails_is_named() -> None:
    row = measured(lambda value, numbers: None if value == "*0.5" else by_chance(numbers))
    assert row is not None
    assert row.verdict == "half fails (ValueError); twice changes no result"
    assert row.measured.startswith("off [mm]: -, ")


def test_a_run_that_does_not_end_is_named() -> None:
    def outcome(run: Try) -> Outcome:
        if run.longest_s:
            raise subprocess.CalledProcessError(-signal.SIGXCPU, [])
        return {"off [mm]": 1.0, "each": [1]}

    row = Measuring(Try("trials", "drives"), outcome).row(SPEED)
    assert row is not None and "does not end" in row.verdict


def test_a_constant_that_an_absurd_value_does_not_show_is_not_measured() -> None:
    assert measured(lambda value, numbers: by_chance(numbers)) is None
    row = measured(lambda value, numbers: 99.0 if value == "*100" else by_chance(numbers))
    assert row is not None and row.verdict == "half and twice: no result differs"


def test_each_room_has_its_trials() -> None:
    assert trials_of(SPEED) == "benchmarks.constant_routes"
    assert trials_of(Constant.of("mapping.exploring.CELL")) == "benchmarks.constant_routes"
    assert trials_of(Constant.of("mapping.ends.FACE")) == "benchmarks.constant_maps"
    assert trials_of(Constant.of("localizer.MIN_DESCRIBED_WEIGHT")) == "benchmarks.constant_trials"


def test_a_page_is_read_as_it_was_written(tmp_path: Path) -> None:
    rows = [
        Row("robot/b.py", "GATE", "2 * 0.1", "Gate | of a door.", "off: 1, 2, 3", "half is worse"),
        Row("robot/a.py", "SD", "(0.1, 0.2)", "", "off: 1, 2, 3", "half and twice: no result"),
    ]
    page = tmp_path / "constants.md"
    write_page(page, rows)
    assert list(read_rows(page).values()) == rows[::-1]
    assert read_rows(tmp_path / "none.md") == {}


def test_a_constant_moves_between_the_sections_of_a_list(tmp_path: Path) -> None:
    path = tmp_path / "list.txt"
    path.write_text(
        "# Why.\n\n[One]\nrobot/a.py: A B\n    C\nrobot/b.py: A\n\n[Other]\nrobot/b.py: D\n"
    )
    move_listed(path, ("robot/b.py", "A"), "[Other]")
    move_listed(path, ("robot/a.py", "C"), None)
    assert path.read_text() == "# Why.\n\n[One]\nrobot/a.py: A B\n\n[Other]\nrobot/b.py: D A\n"
    assert listed_constants(path)["[Other]"] == {"robot/b.py": ["D", "A"]}
