"""diagnostics: the state of program, robot and localization; what is wrong, in plain words."""

from __future__ import annotations

from app.engine.snapshot import Snapshot
from app.ros2.encoding.frames import header
from app.ros2.message_types import Message, new
from app.ros2.source import TopicSource
from robot.localization.integrity import Integrity, State

OK, WARN, ERROR = 0, 1, 2
"""Levels of diagnostic_msgs/DiagnosticStatus."""

LEVELS = {
    State.CERTAIN: OK,
    State.APPROXIMATE: OK,
    State.AMBIGUOUS: WARN,
    State.SEARCHING: WARN,
    State.LOST: ERROR,
}
"""Level of each state without alerts; with an alert, it is at least WARN."""


def diagnostics(source: TopicSource, snapshot: Snapshot) -> Message:
    """The status of the program's loop, of the robot, and of the estimate's integrity."""
    problems, faults = " ".join(snapshot.problems), " ".join(snapshot.reading.faults)
    status = [
        _health(source, "brickpose: program", problems, _figures(snapshot)),
        _health(source, "brickpose: robot", faults, {}),
        _localization(source, snapshot.integrity),
    ]
    position = header(source, snapshot.stamp, "")
    return new("diagnostic_msgs/msg/DiagnosticArray", header=position, status=status)


def _figures(snapshot: Snapshot) -> dict[str, str]:
    loop = snapshot.loop
    return {
        "step_hz": f"{loop.step_hz:.1f}",
        "step_ms": f"{loop.step_ms:.2f}",
        "frame_hz": f"{loop.frame_hz:.1f}",
        "latency_ms": f"{loop.latency_ms:.1f}",
        "mode": snapshot.mode,
        "connected": "true" if snapshot.connected else "false",
    }


def _localization(source: TopicSource, claimed: Integrity) -> Message:
    doubts = [alert.text for alert in claimed.alerts]
    level = max(LEVELS[claimed.state], WARN if doubts else OK)
    figures = {
        "state": claimed.state.value,
        "radius_m": f"{claimed.radius:.5g}",
        "heading_bound_rad": f"{claimed.heading_bound:.5g}",
        "causes": "; ".join(alert.cause.value for alert in claimed.alerts),
        "alerts": "; ".join(doubts),
    }
    message = ": ".join([claimed.state.value, *filter(None, [figures["alerts"]])])
    return _status(source, "brickpose: localization", level, message, figures)


def _health(source: TopicSource, name: str, wrong: str, figures: dict[str, str]) -> Message:
    return _status(source, name, WARN if wrong else OK, wrong or "All is well.", figures)


def _status(
    source: TopicSource, name: str, level: int, message: str, figures: dict[str, str]
) -> Message:
    return new(
        "diagnostic_msgs/msg/DiagnosticStatus",
        level=level,
        name=name,
        message=message,
        hardware_id=source.robot_name,
        values=[new("diagnostic_msgs/msg/KeyValue", key=k, value=v) for k, v in figures.items()],
    )
