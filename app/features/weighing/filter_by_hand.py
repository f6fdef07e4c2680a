"""The last step of the filter by hand, for the page."""

from __future__ import annotations

import sys

import numpy as np
from fastapi import APIRouter, HTTPException

from app.engine.program import Program
from app.engine.steps_by_hand import HandState
from app.features.weighing.messages import HandStepMessage
from app.messages.answers import refusal
from app.messages.telemetry import PoseMessage
from app.page.belief import packed
from robot.fields.floor_picture import Extent
from robot.geometry import Array, heading_vectors, wrap_angle
from robot.localization.filter import Cloud
from robot.localization.filter_by_hand import HandStep
from robot.localization.particles.resampling import effective_sample_size

ALL = sys.maxsize
"""Particles that are sent: only then can the page draw which comes from which."""


def hand_router(program: Program) -> APIRouter:
    """Return the route."""
    router = APIRouter()

    @router.get("/api/filter_by_hand", responses=refusal(404, "while the filter works by itself"))
    def last_step() -> HandStepMessage:
        """The last step by hand, and what it did to the particles."""
        latest = program.engine.latest.get()
        if latest is None or latest.filter.hand is None:
            raise HTTPException(404, "The filter works by itself.")
        return hand_step_message(latest.filter.hand, program.field.extent)

    return router


def hand_step_message(state: HandState, extent: Extent) -> HandStepMessage:
    """Return the last step and its effect on the particles."""
    last = state.last
    noiseless = None if last is None else last.noiseless
    parents = None if last is None else last.parents
    predicts = last is not None and last.noiseless is not None
    return HandStepMessage(
        number=state.number,
        last=None if last is None else last.step,
        extent=list(extent),
        before="" if last is None else packed(last.before, extent, ALL),
        after=packed(state.particles, extent, ALL),
        noiseless="" if noiseless is None else packed(Cloud.even(noiseless), extent, ALL),
        parents=[] if parents is None else parents.tolist(),
        moved=_message(last.moved.to_array()) if last is not None and predicts else None,
        noise=None if last is None else _noise(last),
        effective_before=None if last is None else effective_sample_size(last.before.weights),
        effective=state.effective,
    )


def _noise(step: HandStep) -> PoseMessage | None:
    """Return the standard deviations of a prediction's noise: ahead, aside and in heading."""
    if step.noiseless is None:
        return None
    drawn = step.after.poses - step.noiseless
    ahead = heading_vectors(step.noiseless[:, 2])
    aside = np.column_stack([-ahead[:, 1], ahead[:, 0]])
    along = [(drawn[:, :2] * axis).sum(axis=1).std() for axis in (ahead, aside)]
    return _message(np.array([*along, wrap_angle(drawn[:, 2]).std()]))


def _message(pose: Array) -> PoseMessage:
    x, y, theta = pose.tolist()
    return PoseMessage(x=x, y=y, theta=theta)
