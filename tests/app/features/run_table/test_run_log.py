"""Which runs there are, what each is compared with, and what is handed on."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import replace

import httpx
import pytest
from apps import listening
from engine_runs import kinematic, run
from fastapi import FastAPI

from app.engine.program import Program
from app.engine.snapshot import ReplayState
from app.features.run_table import run_log
from app.features.run_table.routes import runs_message, runs_router
from app.features.run_table.run_log import RunLog
from app.messages.commands import ScatterCommand, SetParametersCommand, SetPoseCommand
from app.messages.driving_commands import FigureEightCommand

EIGHT = FigureEightCommand(type="figure_eight")
WIDE = SetParametersCommand(type="set_parameters", values={"sigma_hit": 0.03})
SCATTER = ScatterCommand(type="scatter")


def drive(program: Program, log: RunLog, seconds: float, *commands) -> None:
    for command in commands:
        for snapshot in run(program, 0.02, command):
            log.add(snapshot)
    for snapshot in run(program, seconds, EIGHT):
        log.add(snapshot)


@pytest.fixture(scope="module")
def driven() -> tuple[Program, RunLog]:
    """Three runs: as at the start, with another parameter, and scattered."""
    program = kinematic()
    log = RunLog(program.field.name)
    drive(program, log, 12.0)
    drive(program, log, 12.0, WIDE)
    drive(program, log, 4.0, SCATTER)
    return program, log


def test_a_run_begins_with_other_parameters_and_with_another_belief(driven) -> None:
    _, log = driven
    assert [each.number for each in log] == [3, 2, 1]
    assert [each.number for each in log.present] == [3]
    scattered, wide, first = runs_message(log, None, 2).runs
    assert (first.parameters, wide.parameters) == ({}, {"sigma_hit": 0.03})
    assert wide.standard == {"sigma_hit": pytest.approx(0.003)}
    assert wide.units == {"sigma_hit": "m"}
    assert not first.present
    assert first.lost < 0.1, "but for the first pictures, when four places look alike"
    assert first.time_to_right < 1.0
    assert scattered.lost > 0.1
    assert 11.0 < first.seconds < 12.5


def test_the_figures_are_those_of_the_ticks() -> None:
    program = kinematic()
    log, errors, seen = RunLog("stub"), [], -math.inf
    for snapshot in run(program, 6.0, EIGHT):
        log.add(snapshot)
        if snapshot.filter.line_scan.scan.stamp > seen:
            seen = snapshot.filter.line_scan.scan.stamp
            errors.append(snapshot.pose.distance_to(snapshot.truth))
    (only,) = runs_message(log, None, None).runs
    assert only.pictures == len(errors) > 100
    assert only.rmse == pytest.approx(math.sqrt(sum(e * e for e in errors) / len(errors)))
    assert only.worst == max(errors)


def test_runs_are_compared_with_the_newest_or_with_one_that_is_chosen(driven) -> None:
    _, log = driven
    chosen = runs_message(log, None, 1)
    assert chosen.against == 1
    _, wide, first = chosen.runs
    assert first.difference is None
    assert wide.difference.rmse == pytest.approx(wide.rmse - first.rmse)
    assert wide.difference.low < wide.difference.rmse < wide.difference.high
    assert runs_message(log, None, None).against == 3
    assert runs_message(log, 2.0, 1).runs[1].seconds <= 2.0


def test_a_robot_that_stands_adds_nothing_and_short_runs_are_not_listed() -> None:
    program = kinematic()
    log = RunLog("stub")
    for snapshot in run(program, 3.0):
        log.add(snapshot)
    assert runs_message(log, None, None).runs[0].pictures == 1
    for y in (0.0, 0.01, 0.0):
        drive(program, log, 0.5, SetPoseCommand(type="set_pose", x=0.0, y=y, theta=0.0))
    assert [each.seconds < 0.6 for each in log] == [True]


def test_kept_runs_stay_and_others_make_room_also_in_the_next_program(driven, monkeypatch) -> None:
    monkeypatch.setattr(run_log, "MOST_RUNS", 3)
    program, log = driven
    later = RunLog("square", log)
    first = next(each for each in later if each.number == 1)
    first.kept = True
    drive(program, later, 2.5)
    drive(program, later, 2.5, SCATTER)
    assert [each.number for each in later] == [5, 4, 3, 1]
    first.kept = False


def test_the_routes_list_keep_and_forget(driven) -> None:
    _, log = driven
    api = FastAPI()
    api.include_router(runs_router(log))
    with (
        listening(api) as address,
        httpx.Client(base_url=f"http://{address}", trust_env=False, timeout=20) as client,
    ):
        assert [each["number"] for each in client.get("/api/runs").json()["runs"]] == [3, 2, 1]
        rows = list(csv.DictReader(io.StringIO(client.get("/api/runs.csv?against=1").text)))
        assert rows[1]["parameters"] == "sigma_hit=0.03"
        assert float(rows[1]["difference_low_m"]) < float(rows[1]["difference_m"])
        assert (rows[2]["difference_m"], rows[2]["run"]) == ("", "1")
        assert client.post("/api/runs/2/keep").status_code == 204
        assert client.get("/api/runs").json()["runs"][1]["kept"]
        assert client.post("/api/runs/2/keep?kept=false").status_code == 204
        assert client.delete("/api/runs/99").status_code == 404
        assert client.delete("/api/runs/3").status_code == 204
        assert [each["number"] for each in client.get("/api/runs").json()["runs"]] == [2, 1]
        assert client.get("/api/runs?last=-1").status_code == 422


def test_in_a_replay_the_recorded_estimate_is_a_run_and_going_back_begins_another() -> None:
    program = kinematic()
    log = RunLog("stub")
    ticks = run(program, 5.0, EIGHT)
    for _ in range(2):
        for snapshot in ticks:
            then = replace(snapshot.truth, x=snapshot.truth.x + 0.004)
            state = ReplayState("lap.mcap", snapshot.stamp, 5.0, 1.0, False, None, then)
            log.add(replace(snapshot, replay=state))
    again, recorded, first = runs_message(log, None, 2).runs
    assert (again.file, recorded.recorded, first.recorded) == ("lap.mcap", True, False)
    assert recorded.rmse == pytest.approx(0.004)
    assert recorded.misleading is None
    assert again.rmse == first.rmse
    assert again.difference.paired, "both have seen the same pictures"
