"""What the terminal says of a recording that was compared with the truth, and asks."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from app.features.lab.asking import ask_which, can_ask
from app.features.lab.report_page import millimetres
from app.features.lab.trajectories.clock_offset import ClockOffset

Ask = Callable[[ClockOffset], float]
"""Asks a person which of several clock offsets it is [s]."""
ATE = {"ate_rmse_m": "unaligned", "ate_aligned_rmse_m": "aligned"}


def recorded_lines(results: dict[str, Any]) -> Iterator[str]:
    """Yield the figures, how much of the run they are of, and what is known of the clocks."""
    experiment = results["experiment"]
    ate = {key: results["methods"]["amcl"][key]["mean"] for key in ATE}
    yield _figures(ate)
    yield from basis_lines(experiment)
    similarity = experiment["similarity"]
    if similarity is not None and similarity["is_free"]:
        yield (
            "the scale is free, as of a single camera: aligned "
            f"{millimetres(ate['ate_aligned_rmse_m'])}, and "
            f"{millimetres(similarity['ate_rmse_m'])} if it is multiplied by "
            f"{similarity['scale']:.4g}"
        )


def basis_lines(experiment: dict[str, Any]) -> Iterator[str]:
    """Yield what the figures rest on: the pairs, and the clocks."""
    yield from experiment["notes"]
    yield pairs_line(experiment)
    yield clock_line(experiment)
    if plain := experiment["without_it"]:
        yield f"without that: {_figures(plain)}, on {plain['poses']} pairs"
    if experiment["clock_offset_choices"]:
        yield rivals_line(experiment)


def _figures(ate: dict[str, Any]) -> str:
    return ", ".join(f"{name} {millimetres(ate[key])}" for key, name in ATE.items())


def pairs_line(experiment: dict[str, Any]) -> str:
    """Return on how many pairs the figures rest, and what part of the recording they cover."""
    judged, duration = experiment["judged"], experiment["recording_duration_s"]
    line = (
        f"on {experiment['poses']} pairs of poses, which cover {judged * duration:.1f} of the "
        f"recording's {duration:.1f} s ({judged:.0%})"
    )
    error = experiment["interpolation_error_m"]
    if error is None:
        return line
    return (
        f"{line}; few stamps meet, so the truth is interpolated, which errs by up to about "
        f"{millimetres(error)} (--max-time-difference pairs the nearest poses instead)"
    )


def clock_line(experiment: dict[str, Any]) -> str:
    """Return the offset of the clocks with its uncertainty, and what was done about it."""
    seconds, added = experiment["clock_offset_s"], experiment["clock_offset_added_s"]
    done = f"{abs(added):.4f} s was {'added to' if added >= 0 else 'taken off'} its stamps"
    if seconds is None:
        return f"the clocks were not compared; {done}"
    if experiment["clock_offset_interval_s"] is None:
        return f"the motion does not tell how far the clocks are apart; {done}"
    low, high = experiment["clock_offset_interval_s"]
    line = (
        f"the recording's clock is {abs(seconds):.4f} s {'behind' if seconds > 0 else 'ahead'} "
        f"(95 %: {low:.4f} to {high:.4f} s to add)"
    )
    if added:
        return f"{line}; {done}"
    if not experiment["clock_offset_sure"]:
        return f"{line}: no more than chance, so its stamps were left"
    return f"{line}; its stamps were left" + (
        "" if experiment["clock_offset_choices"] else ", as that does not show"
    )


def rivals_line(experiment: dict[str, Any]) -> str:
    """Return which other offsets the recording may have, and how to decide."""
    rivals = ", ".join(f"{seconds:.3f}" for seconds in experiment["clock_offset_rivals_s"])
    choices = " or ".join(experiment["clock_offset_choices"])
    return (
        f"off by a lap? The path repeats, and the recording fits as well or better if {rivals} s "
        f"is added; --clock-offset {choices} decides"
    )


def asker() -> Ask | None:
    """Return who can be asked for the offset: a person at a terminal, else nobody."""
    return _asked if can_ask() else None


def _asked(clock: ClockOffset) -> float:
    """Ask for one of the offsets [s]; an empty answer leaves the stamps."""
    place = ask_which(
        "Off by a lap? The path repeats: which offset is to be added to the recording's stamps?",
        [f"{choice} s" for choice in clock.choices],
        "0 s",
    )
    return 0.0 if place is None else float(clock.choices[place])
