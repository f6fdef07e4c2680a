"""Compiled functions of the core that Python calls while a robot drives, with arguments' types.

numba compiles a function when it is first called. With this list it can be done before that, in any
order and by several processes. A test, ``test_compiling.py``, compares it with what a drive calls.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any, NamedTuple

from numba import boolean, float32, float64, int8, int16, int32, int64, uint8, uint32
from numba.core.types import Array, Tuple, UniTuple
from numba.core.types import NamedTuple as Named

from robot.fields.edge_index import EdgeIndex
from robot.fields.unseen_floor import UnseenFloor
from robot.fields.visibility import Visibility
from robot.localization.monitoring.step_sums import StepSums
from robot.localization.ray_evidence import RayEvidence
from robot.localization.scan_matching import ScanMatcher

_F1, _F2, _F3 = float64[::1], float64[:, ::1], float64[:, :, ::1]
_I1, _I2 = int64[::1], int64[:, ::1]
_STEPS = Named((_F2, _F1, _F3, _F2, _F1, _F1, _F1, _F1), StepSums)
_UNSEEN = Named((uint8[:, ::1], float64, float64, float64), UnseenFloor)
_TWO, _THREE, _FOUR = UniTuple(float64, 2), UniTuple(float64, 3), UniTuple(float64, 4)


class Compiled(NamedTuple):
    """A function, and the types of arguments that it is called with."""

    name: str
    """Its module and name, with dots."""
    types: tuple[Any, ...]

    def compile(self) -> None:
        """Compile the function, or load it if it is kept from an earlier time."""
        module, _, name = self.name.rpartition(".")
        getattr(import_module(module), name).compile(self.types)


def _read_only(kind: Any, dimensions: int) -> Any:
    return Array(kind, dimensions, "C", readonly=True)


EDGES = Named(
    (
        *(_read_only(float64, 2), _read_only(float64, 2)),
        *(_read_only(int64, 1), _read_only(int64, 1)),
        *(float64, float64, float64, int64, int64),
    ),
    EdgeIndex,
)
_VISIBLE = Named((boolean[:, ::1], _I1, boolean[::1], float64, EDGES), Visibility)
_MATCHER = Named((EDGES, float64, float64, float64, float64), ScanMatcher)
_EVIDENCE = Named((EDGES, _VISIBLE, float64, float64, float64, _UNSEEN, float64), RayEvidence)

FUNCTIONS: tuple[Compiled, ...] = (
    Compiled("robot.localization.kernels.sampling.tempered", (_F1, _F1, float64, float64)),
    Compiled(
        "robot.scanning.along_rays.hidden_of", (_F3, _F2, int32[::1], int8[::1], int8[::1], _F2)
    ),
    Compiled("robot.scanning.edge_search.differences", (int16[:, ::1], int32[::1], int64)),
    Compiled("robot.scanning.along_rays.points_of", (_F3, _F2, _F2)),
    Compiled(
        "robot.scanning.along_rays.unskew",
        (_F1, *[_F2] * 5, float64, float64, float64),
    ),
    Compiled(
        "robot.fields.visibility._judge_parts",
        (
            _read_only(float64, 2),
            _I1,
            _I1,
            _I1,
            EDGES,
            Tuple((_F1, float64, float64, float64, float64, float64)),
        ),
    ),
    Compiled("robot.localization.kernels.clustering.clustered", (_F2, _F1, float64, int64, int64)),
    Compiled(
        "robot.localization.monitoring.slip_check.slid", (_F2, float64, float64, float64, _F2)
    ),
    Compiled(
        "robot.localization.monitoring.steady_errors.pose_errors",
        (float64, float64, float64, _F1, float64[::1, :], float64, _F1, _F2),
    ),
    Compiled(
        "robot.localization.kernels.spread_copies.spread_copies",
        (_F2, _I1, _F2, _F3, _I1, float64, int64),
    ),
    Compiled(
        "robot.localization.hypotheses.rescoring._rescore",
        (_F1, _F2, _F3, _F3, _MATCHER, _EVIDENCE),
    ),
    Compiled(
        "robot.localization.scan_matching.fit_rays",
        (_F1, float64[::1, :], _F2, _MATCHER),
    ),
    Compiled(
        "robot.localization.scan_matching.fit_rays",
        (_F1, _F2, _F2, _MATCHER),
    ),
    Compiled(
        "robot.localization.monitoring.step_sums.add_step",
        (_STEPS, _F1, _F1, _F1, _TWO, _TWO, _F2, _F2, float64, float64, boolean),
    ),
    Compiled(
        "robot.localization.kernels.ray_sums.sum_over_rays",
        (
            _F2,
            _F1,
            _F1,
            _THREE,
            int64,
            int32[:, :, ::1],
            _TWO,
            float64,
            float64,
            _THREE,
            float64,
            float32[::1],
        ),
    ),
    Compiled(
        "robot.scanning.edge_search.find_edges",
        (
            _read_only(uint8, 2),
            uint32[:, ::1],
            int32[::1],
            float32[:, :, ::1],
            int64,
            int64,
            float64,
            boolean,
        ),
    ),
    Compiled(
        "robot.scanning.tape_edges.judge_pairs",
        (_F3, int32[::1], _F1, float64, float64, float64, float64, float64),
    ),
    Compiled(
        "robot.localization.ray_evidence.ray_log_likelihoods",
        (_F2, _F2, _EVIDENCE, float64),
    ),
    Compiled("robot.localization.ray_evidence.ends_of_seen", (_F1, _F2, _EVIDENCE)),
    Compiled("robot.localization.monitoring.mounting_check._project_out_pose", (_F2, _F2)),
    Compiled("robot.localization.monitoring.mounting_check._solve", (_F2, float64, _F2)),
    Compiled(
        "robot.localization.hypotheses.track._laid",
        (_F1, _F2, _F2, _MATCHER, _EVIDENCE),
    ),
    Compiled("robot.localization.hypotheses.track._around", (_F1, _F2)),
    Compiled("robot.localization.particles.resampling.coarseness", (_F1, _F3, int64, _F1)),
    Compiled("robot.localization.monitoring.step_sums.estimate_errors", (_STEPS,)),
    Compiled("robot.localization.monitoring.step_sums.forget_lateness", (_STEPS, float64, float64)),
    Compiled(
        "sim.floor_kernels.fill_even_strips",
        (
            uint8[:, ::1],
            int32[:, ::1],
            float32[:, ::1],
            *[float32[:, :, ::1]] * 3,
            _I1,
            _I1,
            _F2,
            _F2,
            float64[:, :, ::1],
            _TWO,
            _TWO,
            float64,
            uint8[:, :, ::1],
            UniTuple(int64, 2),
            int64,
        ),
    ),
    Compiled(
        "robot.localization.kernels.beam_sums.beam_log_likelihoods",
        (_F2, _F1, _F2, EDGES, float64, float64, float64, float64, float64),
    ),
    Compiled(
        "robot.localization.hypotheses.coarse_grid._refine_poses",
        (_F2, _F1, _F2, float32[:, :, ::1], _TWO, float64, float64),
    ),
    Compiled("robot.localization.kernels.steps.noisy_step", (_F2, _FOUR, _FOUR, int64)),
    Compiled(
        "robot.localization.hypotheses.coarse_grid._look",
        (float32[:, :, ::1], int64, int64, float32[::1], _I2),
    ),
    Compiled(
        "robot.localization.models.likelihood_field_prob._agreeing",
        (_F2, _F2, _F1, float32[:, :, ::1], _TWO, float64, float64),
    ),
    Compiled(
        "robot.fields.visibility._without_border",
        (boolean[::1], _I1, _read_only(float64, 2), _I1, _I1),
    ),
    Compiled("robot.localization.kernels.steps.turn_go_turn", (_F2, _F1, _F1, _F1, _F1)),
    Compiled(
        "robot.localization.monitoring.scan_residuals.residual_sums",
        (_F1, _F2, EDGES, float64, float64, float64, float64, float64, float64),
    ),
    Compiled("robot.localization.kernels.sampling.count_cells", (_I1, _I1)),
    Compiled("robot.covariance.inverse", (_F2,)),
    Compiled("robot.localization.kernels.sampling.comb", (_F1, int64, float64)),
    Compiled("robot.undistortion.undistorted", (_F2, _F1, float64)),
    Compiled("robot.scanning.along_rays.ranges_of", (_F2, _F3, int8[::1], int8[::1], _F2, _F2)),
    Compiled(
        "robot.localization.hypotheses.coarse_grid._score",
        (_F2, _F1, _F1, _F1, float32[:, :, ::1], _TWO, float64, float64, float32[:, :, ::1]),
    ),
    Compiled("sim.floor_kernels.affines_at", (_F1, _F1, _F3)),
    Compiled("sim.floor_kernels.fill_uneven_strips", (uint8[:, ::1], int32[:, :], uint8[::1], _I1)),
)
"""A few quick ones come first, so that progress is seen at once; then the slowest, so that all
cores are done at about the same time."""
