"""Compare a recorded trajectory with the true one, such as from a motion capture system."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from app.features.lab.evaluation.recorded_words import Ask, basis_lines
from app.features.lab.evaluation.report import recorded_errors, recorded_paths
from app.features.lab.evaluation.results import method_table
from app.features.lab.evaluation.runs import SHOWN, score
from app.features.lab.localize.reading.bag_trajectory import read_any
from app.features.lab.report_page import page
from app.features.lab.trajectories.association import NEAREST, Pairs, pairs_of
from app.features.lab.trajectories.clock_offset import ClockOffset, require_same_run
from app.features.lab.trajectories.metrics import absolute_errors, align, ate_rmse, fit_scale
from app.features.lab.trajectories.unstamped import UNDERSTOOD
from app.result_files import RESULTS, atomic_folder, make_folder, write_json
from app.settings.provenance import versions
from app.trajectories.trajectory import LEFT_OUT, Trajectory, TrajectoryError
from app.trajectories.tum_file import write_tum
from robot.settings import SettingError

SHOWS = 0.1
"""A sure clock offset of no more than 10 ms, the tolerance of stamps that are paired, is corrected
only if that reduces the aligned error by more than this part."""
TEMPLATE = "recorded.html.jinja"
STANDING, OTHER_UNITS = 1e-3, 20.0
"""A trajectory that spreads by less than the first does not move [m]; one that is more than the
second times as large as the other has other units."""
USUALLY = 90
"""Percentile of the distances from the middle that is a trajectory's size."""
TOLD = (LEFT_OUT, UNDERSTOOD)
"""Starts of the notes about a file that its user should know."""
RUN = "run:"
"""Start of the comment in a trajectory file that names its run."""


@dataclass(frozen=True)
class Recording:
    """Two trajectories of one run."""

    pairs: Pairs
    """Their poses, the estimate's on the truth's clock."""
    clock: ClockOffset | None
    """The estimated clock offset; None if the offset was given."""
    added: float
    """Time added to the stamps of the estimate [s]."""
    unshifted: Pairs | None
    """The pairs without that time, if it was estimated and stamps as they are have pairs."""
    duration: float
    """Of the recording [s]."""
    notes: tuple[str, ...]
    """What of the files was left out, or how they were understood."""


@dataclass(frozen=True)
class ComparisonOptions:
    """How two files are read and compared."""

    body: str | None = None
    """Which rigid body of a motion capture's file."""
    clock_offset: str = "auto"
    """What to add to the recording's stamps [s], or "auto"."""
    max_difference: float | None = None
    """Largest difference of two stamps of a pair [s]; None as in `pairs_of`."""
    topics: tuple[str | None, str | None] = (None, None)
    """Topics or transforms of a recording and a truth that are bags."""


AS_USUAL = ComparisonOptions()


def reading_of(given: dict[str, Any]) -> ComparisonOptions:
    """Return how the options of the command line say that files are read.

    Raises:
        SettingError: the largest time difference is not positive.
    """
    largest = given.get("max_time_difference")
    if largest is not None and not 0 < largest < math.inf:
        raise SettingError(
            f"--max-time-difference is {largest:g}; valid is a positive number of seconds"
        )
    return ComparisonOptions(
        given.get("body"),
        given.get("clock_offset", "auto"),
        largest,
        (given.get("recording_topic"), given.get("truth_topic")),
    )


def read_recording(
    recording: Path, truth: Path, how: ComparisonOptions = AS_USUAL, ask: Ask | None = None
) -> Recording:
    """Read and pair two trajectories.

    Args:
        ask: who says which offset it is if a repeated path leaves several; None leaves the stamps.

    Raises:
        TrajectoryError: a file cannot be read (names file and line), or the two are not of one run.
        SettingError: the clock offset is neither a number nor "auto".
    """
    if how.body is not None and not (_is_table(truth) or _is_table(recording)):
        raise SettingError(
            "--body is of a file of Motive or Vicon (.csv) or Qualisys (.tsv), and neither is one"
        )
    estimate, true = (
        _read(path, how.body, topic)
        for path, topic in zip((recording, truth), how.topics, strict=True)
    )
    notes = tuple(note for item in (estimate, true) for note in item.notes if note.startswith(TOLD))
    _check_notes(true, estimate)
    _check_sizes(true, estimate)
    if true.planar or estimate.planar:
        # A planar trajectory has no height and no tilt, so they do not count as errors.
        true, estimate = true.to_planar(), estimate.to_planar()

    def paired(added: float) -> Pairs:
        return pairs_of(true, estimate.shifted(added), how.max_difference)

    added, clock = clock_of(how.clock_offset), None
    if added is None:
        try:
            clock = require_same_run(true, estimate)
        except TrajectoryError as error:
            # What is doubtful about the files may be why.
            raise TrajectoryError("; ".join([str(error), *notes])) from error
        added = clock.correction
        if clock.by_stamps and clock.rivals and ask is not None:
            added = ask(clock)
        elif clock.by_stamps and 0 < abs(added) <= NEAREST and not _shows(added, paired):
            added = 0.0
    unshifted = None
    if clock is not None and added:
        with suppress(TrajectoryError):  # the stamps as they are may have no pairs
            unshifted = paired(0.0)
    return Recording(paired(added), clock, added, unshifted, estimate.duration, notes)


def evaluate_recording(
    recording: Path,
    truth: Path,
    folder: Path,
    how: ComparisonOptions = AS_USUAL,
    ask: Ask | None = None,
) -> dict[str, Any]:
    """Write ``results.json``, ``report.html``, ``figure3.svg`` and the pairs that were compared.

    Raises:
        TrajectoryError, SettingError: as `read_recording`.
        OSError: the folder cannot be written.
    """
    make_folder(folder)
    read = read_recording(recording, truth, how, ask)
    pairs = read.pairs
    with atomic_folder(folder) as new:
        results = _results(read, recording, truth)
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
                lines=[line[0].upper() + line[1:] for line in basis_lines(results["experiment"])],
                method=results["methods"]["amcl"],
                paths=figure,
                over_time=recorded_errors(stamps, offset),
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


def _read(path: Path, body: str | None, topic: str | None) -> Trajectory:
    """Read a trajectory; only a table has a body, and the other file may be of another kind."""
    return read_any(path, body if _is_table(path) else None, topic)


def _is_table(path: Path) -> bool:
    return path.name.lower().removesuffix(".gz").endswith((".csv", ".tsv"))


def _check_sizes(true: Trajectory, estimate: Trajectory) -> None:
    """Refuse a trajectory that does not move, or that cannot be in metres.

    Raises:
        TrajectoryError: names the trajectory.
    """
    sizes = []
    for item in (true, estimate):
        spread = np.linalg.norm(item.positions - np.median(item.positions, axis=0), axis=1)
        if float(spread.max()) < STANDING:
            raise TrajectoryError(f"{item.name} does not move; is it of the robot?")
        # A few wild poses do not make a path large, nor does a long rest make it small.
        sizes.append(max(float(np.percentile(spread, USUALLY)), STANDING))
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


def _results(read: Recording, recording: Path, truth: Path) -> dict[str, Any]:
    pairs = read.pairs
    return {
        "experiment": {
            "recording": recording.name,
            "truth": truth.name,
            "seeds": 1,
            "poses": len(pairs),
            "duration_s": float(pairs.truth.stamps[-1] - pairs.truth.stamps[0]),
            "recording_duration_s": read.duration,
            "judged": pairs.judged,
            "interpolation_error_m": pairs.interpolation_error,
            "notes": list(read.notes),
            **_clock_table(read),
            "similarity": _similarity(pairs),
            "rpe_over": SHOWN,
            "settings": {},
            "versions": versions(),
        },
        "methods": {"amcl": method_table([score(pairs.truth, pairs.estimate)])},
        "recovery": None,
    }


def _clock_table(read: Recording) -> dict[str, Any]:
    """Return what ``results.json`` says of the clocks; all None if the offset was given."""
    clock, plain = read.clock, read.unshifted
    has_deviation = clock is not None and math.isfinite(clock.shift.deviation)
    return {
        "clock_offset_s": clock.seconds if clock else None,
        "clock_offset_sd_s": clock.shift.deviation if clock and has_deviation else None,
        "clock_offset_interval_s": list(clock.shift.interval) if clock and has_deviation else None,
        "clock_offset_sure": clock.shift.is_significant if clock else None,
        "clock_offset_rivals_s": list(clock.rivals) if clock else None,
        "clock_offset_choices": list(clock.choices) if clock and clock.rivals else None,
        "clock_offset_added_s": read.added,
        "without_it": plain
        and {
            "poses": len(plain),
            "ate_rmse_m": ate_rmse(plain.truth, plain.estimate),
            "ate_aligned_rmse_m": ate_rmse(plain.truth, plain.estimate, aligned=True),
        },
        "motion_correlation": clock.correlation if clock else None,
    }


def _similarity(pairs: Pairs) -> dict[str, Any] | None:
    """Return how the estimate fits with a free scale; None if it cannot be aligned."""
    try:
        fit = fit_scale(pairs.truth, pairs.estimate)
    except TrajectoryError:
        return None
    return {"scale": fit.scale, "ate_rmse_m": fit.scaled, "is_free": fit.is_free}


def _shows(offset: float, paired: Callable[[float], Pairs]) -> bool:
    """Whether the correction of a small offset [s] reduces the aligned error."""
    as_it_is, set_right = (
        ate_rmse(pairs.truth, pairs.estimate, aligned=True)
        for pairs in (paired(0.0), paired(offset))
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
