"""A robot is driven over a live connection, and its estimate compared with the truth."""

from __future__ import annotations

import json

import numpy as np
from serving import pose_error, until


def errors_of_a_drive(live, seconds: float) -> np.ndarray:
    """Distances of the estimate from the truth while it drives arcs near the field's start [m]."""
    began, errors = None, []

    def driving(now: dict) -> bool:
        nonlocal began
        began = now["stamp"] if began is None else began
        forth = (now["stamp"] - began) % 4 < 2
        live.send(json.dumps({"type": "drive", "v": 0.1 if forth else -0.1, "omega": 0.6}))
        errors.append(pose_error(now))
        return now["stamp"] - began > seconds

    until(live, driving, 60)
    return np.array(errors)


def at_the_start(live) -> None:
    """Put the robot on the field's start, and tell the filter."""
    for kind in ("place", "set_pose"):
        live.send(json.dumps({"type": kind, "x": 0.0, "y": 0.0, "theta": 0.0}))
