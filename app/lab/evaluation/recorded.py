"""Compare a recorded trajectory with the true one, such as from a motion capture system."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from app.files import RESULTS, atomic_folder, write_json
from app.lab.evaluation.report import recorded_errors, recorded_paths
from app.lab.evaluation.results import method_table
from app.lab.evaluation.runs import SHOWN, score
from app.lab.report_page import embedded, page
from app.lab.trajectories.association import associate
from app.lab.trajectories.clock_offset import ClockOffset, require_same_run
from app.lab.trajectories.metrics import absolute_errors, align, ate_rmse, fit_scale
from app.lab.trajectories.reading import read_trajectory, write_tum
from app.lab.trajectories.trajectory import Trajectory, TrajectoryError
from app.settings.provenance import versions
from robot.settings import SettingError

TOLERANCE = 0.01
"""Largest difference of the two stamps of a pair [s]."""
SHOWS = 0.1
"""A clock offset within TOLERANCE is corrected only if that reduces the aligned error by more than
this part."""
TEMPLATE = "recorded.html.jinja"
STANDING, OTHER_UNITS = 1e-3, 20.0
"""A trajectory that spreads by less than the first does not move [m]; one that is more than the
second times as large as the other has other units."""
RUN = "run:"
"""Start of the comment in a trajectory file that names its run."""


@dataclass(frozen=True)
class Recording:
    """Two trajectories of one run."""

    truth: Trajectory
    """Its poses are paired with those of the estimate."""
    estimate: Trajectory
    """On the truth's clock."""
    clock: ClockOffset | None
    """The estimated clock offset; None if the offset was given."""
    added: float
    """Time added to the stamps of the estimate [s]."""


def read_recording(
    recording: Path, truth: Path, body: str | None, clock_offset: str = "auto"
) -> Recording:
    """Read and associate two trajectories.

    Args:
        body: which rigid body of a Motive file.
        clock_offset: what to add to the recording's stamps [s], or "auto".

    Raises:
        TrajectoryError: a file cannot be read (names file and line), or the two are not of one run.
        SettingError: the clock offset is neither a number nor "auto".
    """
    if body is not None and not (_is_csv(truth) or _is_csv(recording)):
        raise SettingError("--body is of a file of Motive (.csv), and neither is one")
    true, estimate = _read(truth, body), _read(recording, body)
    _check_notes(true, estimate)
    _check_sizes(true, estimate)
    if true.planar or estimate.planar:
        # A planar trajectory has no height and no tilt, so they do not count as errors.
        true, estimate = true.to_planar(), estimate.to_planar()
    asked, clock = clock_of(clock_offset), None
    if asked is None:
        clock = require_same_run(true, estimate)
        asked = clock.seconds if _needs_correction(clock.seconds, true, estimate) else 0.0
    return Recording(*associate(true, estimate.shifted(asked), TOLERANCE), clock, asked)


def evaluate_recording(
    recording: Path, truth: Path, folder: Path, body: str | None, clock_offset: str
) -> dict[str, Any]:
    """Write ``results.json``, ``report.html``, ``figure3.svg`` and the pairs that were compared.

    Raises:
        TrajectoryError, SettingError: as `read_recording`.
        OSError: the folder cannot be written.
    """
    pairs = read_recording(recording, truth, body, clock_offset)
    with atomic_folder(folder) as new:
        results = _results(pairs, recording, truth)
        aligned = align(pairs.truth, pairs.estimate).apply(pairs.estimate)
        figure = recorded_paths(pairs.truth, pairs.estimate, aligned)
        offset = {
            "as it is": absolute_errors(pairs.truth, pairs.estimate),
            "aligned": absolute_errors(pairs.truth, aligned),
        }
        stamps = pairs.truth.stamps - pairs.truth.stamps[0]
        (new / "figure3.svg").write_text(figure, encoding="utf-8")
        (new / "report.html").write_text(
            page(
                TEMPLATE,
                experiment=results["experiment"],
                method=results["methods"]["amcl"],
                paths=embedded(figure),
                over_time=embedded(recorded_errors(stamps, offset)),
                settings={},
            ),
            encoding="utf-8",
        )
        run = new / "runs" / "0"
        run.mkdir(parents=True)
        for name, item in (("truth", pairs.truth), ("recording", pairs.estimate)):
            write_tum(run / f"{name}.tum", item, [n for n in item.notes if n.startswith(RUN)])
        write_json(new / RESULTS, results)
    return results


def _read(path: Path, body: str | None) -> Trajectory:
    """Read a trajectory; only a CSV file has a body, and the other file may be of another kind."""
    return read_trajectory(path, body if _is_csv(path) else None)


def _is_csv(path: Path) -> bool:
    return path.name.lower().removesuffix(".gz").endswith(".csv")


def _check_sizes(true: Trajectory, estimate: Trajectory) -> None:
    """Refuse a trajectory that does not move, or that cannot be in metres.

    Raises:
        TrajectoryError: names the trajectory.
    """
    sizes = []
    for item in (true, estimate):
        sizes.append(float(np.linalg.norm(np.std(item.positions, axis=0))))
        if sizes[-1] < STANDING:
            raise TrajectoryError(f"{item.name} does not move; is it of the robot?")
    ratio = max(sizes) / min(sizes)
    if ratio > OTHER_UNITS:
        larger, smaller = (true, estimate) if sizes[0] > sizes[1] else (estimate, true)
        raise TrajectoryError(
            f"{larger.name} is {ratio:.0f} times as large as {smaller.name}; valid are metres; "
            "an estimate of a single camera is in none, and is to be given a scale first"
        )


def _check_notes(true: Trajectory, estimate: Trajectory) -> None:
    """Refuse files whose notes name different runs.

    Two runs of the same drive move alike, so the motion alone cannot tell them apart.

    Raises:
        TrajectoryError: the notes name different runs.
    """
    run_of = [{n for n in item.notes if n.startswith(RUN)} for item in (true, estimate)]
    if all(run_of) and run_of[0].isdisjoint(run_of[1]):
        given = [min(notes).removeprefix(RUN).strip() for notes in run_of]
        raise TrajectoryError(
            f"{true.name} is of another run than {estimate.name}: of {given[0]}, and of {given[1]}"
        )


def _results(pairs: Recording, recording: Path, truth: Path) -> dict[str, Any]:
    clock = pairs.clock
    return {
        "experiment": {
            "recording": recording.name,
            "truth": truth.name,
            "seeds": 1,
            "poses": len(pairs.truth),
            "duration_s": float(pairs.truth.stamps[-1] - pairs.truth.stamps[0]),
            "clock_offset_s": clock.seconds if clock else None,
            "clock_offset_added_s": pairs.added,
            "motion_correlation": clock.correlation if clock else None,
            "similarity": _similarity(pairs),
            "rpe_over": SHOWN,
            "settings": {},
            "versions": versions(),
        },
        "methods": {"amcl": method_table([score(pairs.truth, pairs.estimate)])},
        "recovery": None,
    }


def _similarity(pairs: Recording) -> dict[str, Any] | None:
    """Return how the estimate fits with a free scale; None if it cannot be aligned."""
    try:
        fit = fit_scale(pairs.truth, pairs.estimate)
    except TrajectoryError:
        return None
    return {"scale": fit.scale, "ate_rmse_m": fit.scaled, "is_free": fit.is_free}


def _needs_correction(offset: float, true: Trajectory, estimate: Trajectory) -> bool:
    """Whether to correct a clock: it exceeds the tolerance, or the correction reduces the error."""
    if abs(offset) > TOLERANCE:
        return True
    as_it_is, set_right = (
        ate_rmse(*associate(true, estimate.shifted(added), TOLERANCE), aligned=True)
        for added in (0.0, offset)
    )
    return set_right < (1 - SHOWS) * as_it_is


def clock_of(text: str) -> float | None:
    """Parse a clock offset [s]; None for "auto".

    Raises:
        SettingError: the text is neither a number nor "auto".
    """
    if text == "auto":
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise SettingError(f"--clock-offset is {text!r}; valid is auto or a number of seconds")
    return value
