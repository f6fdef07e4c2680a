"""Claims as a filter might make them, without one."""

from __future__ import annotations

import math

import numpy as np

from app.features.lab.evaluation.integrity.claims import Claims
from robot.localization.estimate import State

PERIOD = 0.1


def claims_made(errors, state=State.CERTAIN, radius=0.01, cause=None, turn=0.0, carry_stamp=None):
    """One picture each 0.1 s, off by so much along x [m]; each value may be a list or one."""
    count = len(errors)
    truth = np.zeros((count, 3))
    poses = truth.copy()
    poses[:, 0] = errors
    poses[:, 2] = turn
    sd = 0.005
    return Claims(
        PERIOD * np.arange(count),
        truth,
        poses,
        np.tile(np.diag(np.square([sd, sd, 0.01])), (count, 1, 1)),
        np.ones(count),
        tuple(state) if isinstance(state, list) else (state,) * count,
        np.broadcast_to(np.asarray(radius, dtype=float), count).copy(),
        np.full(count, math.radians(3)),
        tuple(cause) if isinstance(cause, list) else (cause,) * count,
        carry_stamp,
    )
