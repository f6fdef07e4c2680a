"""Which parameters have no effect, as the chosen filter and models do not use them."""

from __future__ import annotations

import dataclasses

from robot.localization.filter_kinds import FILTERS, FilterKind
from robot.localization.models.motion_models import MODELS, MotionParameters
from robot.localization.models.sensor_models import SensorParameters
from robot.localization.parameters import HypothesisParameters, LocalizationParameters

BEAM = frozenset(["z_short", "z_max", "lambda_short"])
"""Of the beam model alone."""
SKIPPING = frozenset(["beam_skip_distance", "beam_skip_threshold", "beam_skip_error_threshold"])
"""Of beam skipping."""
MODEL = BEAM | SKIPPING | {"laser_model_type", "z_hit", "z_rand", "do_beamskip"}
"""Of sensor models: a Kalman filter lays rays on edges and has none."""
PARTICLES = frozenset(
    [
        "min_particles",
        "max_particles",
        "pf_err",
        "pf_z",
        "recovery_alpha_slow",
        "recovery_alpha_fast",
        "resample_interval",
        "selective_resampling",
        "min_effective",
        "regularization",
        "cell_xy",
        "cell_theta",
    ]
)
"""Of filters with particles."""
EVIDENCE = frozenset(["fit_sd", "fit_gate"])
"""Of all filters: places are weighed by them, and whether an estimate can be relied on."""


def _names(group: type) -> frozenset[str]:
    return frozenset(field.name for field in dataclasses.fields(group))


HYPOTHESES = _names(HypothesisParameters) - EVIDENCE
"""Of several hypotheses."""


def idle_parameters(
    parameters: LocalizationParameters, *, own_motion: bool = False, own_sensor: bool = False
) -> frozenset[str]:
    """Return the names of the parameters that have no effect now.

    Args:
        parameters: the present ones.
        own_motion: whether a user's own motion model is used, which has its own parameters.
        own_sensor: whether a user's own sensor model is used.
    """
    motion = () if own_motion else MODELS[parameters.motion.robot_model_type][1]
    idle = _names(MotionParameters) - {"robot_model_type", *motion}
    return (
        idle
        | _idle_sensor(parameters.sensor, own=own_sensor)
        | _idle_filter(FILTERS[parameters.filter.filter])
    )


def _idle_filter(kind: FilterKind) -> frozenset[str]:
    hypotheses = frozenset() if kind.has_hypotheses else HYPOTHESES
    particles = frozenset() if kind.has_particles else PARTICLES
    return hypotheses | particles | (frozenset() if kind.has_sensor_model else MODEL)


def _idle_sensor(sensor: SensorParameters, *, own: bool) -> frozenset[str]:
    if own:
        return MODEL - {"laser_model_type"}
    if sensor.laser_model_type == "beam":
        return SKIPPING | {"do_beamskip"}
    if sensor.laser_model_type != "likelihood_field_prob":
        return BEAM | SKIPPING | {"do_beamskip"}
    return BEAM if sensor.do_beamskip else BEAM | SKIPPING
