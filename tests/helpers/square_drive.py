"""Setups of the hypotheses on the fields "stub" and "square", and a robot that drives there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from stub_drive import DEFAULTS, ENTRIES, MAPS, SENSOR, STUB, Drive, near

from robot.fields.field import Field
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.localization.estimate import Hypothesis
from robot.localization.filter import Setup
from robot.localization.models.entry_field import EntryField
from robot.localization.models.sensor_models import sensor_model

SQUARE = load_field("square", MAPS)
MOTION = DEFAULTS.motion.model()
NARROW = np.diag(np.square([0.005, 0.005, 0.02]))


def setup_of(of: Field, entries: EntryField, **changes: float) -> Setup:
    parameters = replace(DEFAULTS, hypotheses=replace(DEFAULTS.hypotheses, **changes))
    return Setup.of(
        of, entries, MOTION, sensor_model(DEFAULTS.sensor, entries, of.edges), parameters
    )


ON_STUB = Setup.of(STUB, ENTRIES, MOTION, SENSOR, DEFAULTS)
ON_SQUARE = setup_of(SQUARE, EntryField.build(SQUARE, resolution=0.005, max_distance=0.15))


def drive_on(of: Field, start: Pose2, seed: int = 0) -> Drive:
    return Drive(start, edges_of=of, rng=np.random.default_rng(seed))


def right(one: Hypothesis, drive: Drive) -> bool:
    return near(one.pose, drive.true, 0.01, 0.03)
