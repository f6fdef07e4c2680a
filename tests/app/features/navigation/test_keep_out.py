"""Keep-out zones and the switch of tape: commands, what is refused, routes, recordings."""

from __future__ import annotations

import base64
from collections.abc import Iterator

import numpy as np
import pytest
from journeys import PAGE, JourneyBench, goal

from app.engine.commands import parse
from app.features.navigation.messages import NavigateCommand, SetWallsCommand
from app.page.telemetry import TelemetryWriter
from robot.errors import CommandError

ZONE = [(0.16, -0.06), (0.18, -0.06), (0.18, 0.06), (0.16, 0.06)]
BEHIND = goal(0.34, 0.0, 0.0)


def walls(**said) -> SetWallsCommand:
    return SetWallsCommand(type="set_walls", **said)


@pytest.fixture
def bench() -> Iterator[JourneyBench]:
    made = JourneyBench()
    yield made
    made.close()


def answer(bench: JourneyBench, path: str):
    """What a route of navigation answers."""
    outlet = bench.outlets._outlets["navigation"]
    (router,) = outlet.routers()
    (route,) = (each for each in router.routes if each.path == f"/api/navigation{path}")
    return route.endpoint()


def test_the_way_leads_around_a_zone_and_the_layer_shows_it(bench):
    bench.send(BEHIND)
    bench.go(0.4)
    straight = bench.status.path
    assert np.abs(straight[:, 1]).max() < 0.02
    bench.send(walls(zones=[ZONE]))
    bench.go(2.0)
    around = bench.status.path
    assert np.abs(around[:, 1]).max() > 0.15
    told = answer(bench, "/walls")
    assert (told.tape, told.zones) == ("wall", [[list(corner) for corner in ZONE]])
    message = TelemetryWriter(bench.program, bench.outlets).message(bench.now)
    assert message.walls > 0
    costs = answer(bench, "/costs")
    cells = np.frombuffer(base64.b64decode(costs.cells), np.uint8)
    cells = cells.reshape(costs.rows, costs.columns)
    row, column = int(-costs.y / costs.step), int((0.17 - costs.x) / costs.step)
    assert cells[row, column] == 254
    bench.send(walls(zones=[]))
    bench.go(0.1)
    assert answer(bench, "/walls").zones == []


def test_a_goal_in_a_zone_is_refused_and_says_that_it_is_a_zone(bench):
    bench.send(walls(zones=[ZONE]))
    bench.go(0.1)
    with pytest.raises(CommandError, match="would touch a keep-out zone"):
        bench.send(goal(0.17, 0.0, 0.0))
    with pytest.raises(CommandError, match="on a wall"):
        bench.send(goal(0.5, 0.0, 0.0))


def test_tape_that_is_ignored_is_crossed(bench):
    with pytest.raises(CommandError, match="on a wall"):
        bench.send(goal(0.5, 0.0, 0.0))
    bench.send(walls(tape="ignored"))
    bench.go(0.1)
    assert answer(bench, "/walls").tape == "ignored"
    bench.send(goal(0.5, 0.0, 0.0))
    bench.send(walls(tape="wall"))
    bench.go(0.1)
    with pytest.raises(CommandError, match="on a wall"):
        bench.send(goal(0.5, 0.0, 0.0))


def test_a_journey_tells_recordings_what_was_said_before_it(bench):
    bench.send(walls(zones=[ZONE]))
    bench.go(0.1)
    bench.send(BEHIND)
    told = [command for each in bench.go(0.2) for command in each.commands]
    assert [each for each in told if isinstance(each, SetWallsCommand)] == [walls(zones=[ZONE])]
    assert any(isinstance(each, NavigateCommand) for each in told)


@pytest.mark.parametrize(
    ("zones", "words"),
    [
        ([[(0, 0), (1, 1), (1, 0), (0, 1)]], "crosses itself"),
        ([[(0, 0), (0, 0), (0, 0)]], "is no area"),
        ([[(9, 9), (9.5, 9), (9, 9.5)]], "beyond the field; valid is x -0.750 to 0.750"),
    ],
)
def test_what_is_no_zone_is_refused(bench, zones, words):
    with pytest.raises(CommandError, match=words):
        bench.send(walls(zones=zones), PAGE)


@pytest.mark.parametrize(
    "text", ['{"zones": [[[0, 0], [1, 1]]]}', '{"zones": [[[0, 0], [1, NaN], [1, 1]]]}',
             '{"tape": "glue"}']
)  # fmt: skip
def test_what_is_no_command_is_refused(text):
    with pytest.raises(CommandError):
        parse('{"type": "set_walls", ' + text[1:])
