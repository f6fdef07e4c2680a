"""One line puts a value of a tick on the page, on ROS and into recordings."""

from __future__ import annotations

import json
from collections.abc import Iterator

import pytest
from engine_runs import EIGHT, kinematic, run

from app.engine.plugging import plug_in, plugged
from app.engine.value import Shown, Value
from app.feature import Feature
from app.features.ros.outlet import PUBLISHER
from app.features.ros.topics import TOPICS, Published
from app.page.outlets import Outlets
from app.page.telemetry import TelemetryWriter

UPDATES = Value("filter_updates", lambda snapshot: snapshot.filter.updates)


@pytest.fixture
def with_updates() -> Iterator[None]:
    """The program with one value more."""
    before = plugged().features
    plug_in(before.adding(Feature(name="more", about="", values=(lambda: [UPDATES],))))
    yield
    plug_in(before)


def shown() -> tuple[dict[str, object], dict[str, str], int]:
    """The telemetry after a short drive, the program's figures on ROS, and the true value."""
    program = kinematic()
    snapshot = run(program, 0.5, EIGHT)[-1]
    outlets = Outlets(program)
    telemetry = TelemetryWriter(program, outlets).message(snapshot).model_dump_json()
    [topic] = [topic for topic in TOPICS if topic.name == "diagnostics"]
    # A recording has the same bytes as the live routes.
    message = Published(topic, snapshot.stamp, outlets.part(PUBLISHER).source, snapshot).message
    outlets.close()
    figures = {each.key: each.value for each in message.status[0].values}
    return json.loads(telemetry), figures, snapshot.filter.updates


def test_a_value_is_on_the_page_on_ros_and_in_recordings(with_updates: None) -> None:
    telemetry, figures, updates = shown()
    assert updates > 0
    assert telemetry["values"]["filter_updates"] == updates
    assert figures["filter_updates"] == str(updates)


def test_without_further_values_the_wire_has_those_of_our_features() -> None:
    telemetry, figures, _ = shown()
    # Motion is not measured in pictures here.
    assert telemetry["values"] == dict.fromkeys(("floor_seen", "floor_speed_mm_s", "wheels"))
    assert list(figures) == [
        "step_hz", "step_ms", "frame_hz", "latency_ms", "mode", "connected",
        "wheels", "floor_seen", "floor_speed_mm_s",
    ]  # fmt: skip
    assert figures["connected"] == "true"


@pytest.mark.parametrize(
    ("value", "form", "text"),
    [(True, "", "true"), (None, ".1f", ""), (1.25, ".1f", "1.2"), (3, "", "3"), ("on", "", "on")],
)
def test_how_ros_writes_a_value(value: Shown, form: str, text: str) -> None:
    [snapshot] = run(kinematic(), 0.02)
    assert Value("value", lambda _: value, form).text(snapshot) == text
