"""The values that ticks show, ours and those of features."""

from __future__ import annotations

from app.engine.plugging import plugged
from app.engine.snapshot import Snapshot
from app.engine.value import UNREADABLE, Shown, Value

VALUES = (
    Value("step_hz", lambda snapshot: snapshot.loop.step_hz, ".1f", listed=False),
    Value("step_ms", lambda snapshot: snapshot.loop.step_ms, ".2f", listed=False),
    Value("frame_hz", lambda snapshot: snapshot.loop.frame_hz, ".1f", listed=False),
    Value("latency_ms", lambda snapshot: snapshot.loop.latency_ms, ".1f", listed=False),
    Value("mode", lambda snapshot: snapshot.mode, listed=False),
    Value("connected", lambda snapshot: snapshot.connected, listed=False),
)


def values() -> tuple[Value, ...]:
    """Return all values, in their order, ours first."""
    return plugged().values


def value_failures() -> list[str]:
    """Return why some values cannot be read now, for people."""
    return [UNREADABLE[value.name] for value in values() if value.name in UNREADABLE]


def listed(snapshot: Snapshot) -> dict[str, Shown] | None:
    """Return the values that telemetry has nowhere else; None without any."""
    shown = {value.name: value.shown(snapshot) for value in values() if value.listed}
    return shown or None
