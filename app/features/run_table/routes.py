"""Routes that list runs, compare them, keep and forget them."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable
from dataclasses import asdict
from typing import Annotated

from fastapi import APIRouter, HTTPException, Query, Response

from app.features.run_table.figures import RunSamples, difference_of, figures_of
from app.features.run_table.messages import RunDifferenceMessage, RunMessage, RunsMessage
from app.features.run_table.run_log import UNITS, ListedRun, Parameters, RunLog, differences
from app.messages.answers import content, refusal

Seconds = Annotated[float, Query(gt=0, le=1e6)]
Number = Annotated[int, Query(ge=1)]
NO_RUN = refusal(404, "no such run")
COLUMNS = (
    "run", "replays", "recorded", "field", "parameters", "pictures", "seconds", "rmse_m",
    "median_m", "worst_m", "lost", "misleading", "time_to_right_s", "difference_m",
    "difference_low_m", "difference_high_m", "paired",
)  # fmt: skip


def runs_router(log: RunLog) -> APIRouter:
    """Return the routes of a log."""
    router = APIRouter()

    @router.get("/api/runs")
    def runs(last: Seconds | None = None, against: Number | None = None) -> RunsMessage:
        """The runs since the start, and how each differs from one of them, by default the newest.

        ``last`` counts only so many seconds at the end of each.
        """
        return runs_message(log, last, against)

    @router.get("/api/runs.csv", response_class=Response, responses=content("text/csv"))
    def table(last: Seconds | None = None, against: Number | None = None) -> Response:
        """The same as a table."""
        text = _table(runs_message(log, last, against).runs)
        headers = {"Content-Disposition": 'attachment; filename="runs.csv"'}
        return Response(text, media_type="text/csv", headers=headers)

    @router.post("/api/runs/{number}/keep", responses=NO_RUN, status_code=204)
    def keep(number: int, kept: bool = True) -> None:
        """Keep a run listed however many follow, or no more."""
        _run(number).kept = kept

    @router.delete("/api/runs/{number}", responses=NO_RUN, status_code=204)
    def forget(number: int) -> None:
        """List a run no more."""
        log.forget(_run(number))

    def _run(number: int) -> ListedRun:
        run = log.run(number)
        if run is None:
            raise HTTPException(404, f"there is no run {number} any more")
        return run

    return router


def runs_message(log: RunLog, last: float | None, against: int | None) -> RunsMessage:
    """Return the runs that have pictures, over all of each or its last seconds."""
    seen = [(run, _end(run.samples, last)) for run in log]
    seen = [(run, samples) for run, samples in seen if samples.stamps.size]
    number = against if any(run.number == against for run, _ in seen) else None
    if number is None and seen:
        number = seen[0][0].number
    other = next((samples for run, samples in seen if run.number == number), None)
    made = (_message(run, samples, other, number, log) for run, samples in seen)
    return RunsMessage(against=number, runs=list(made))


def _end(samples: RunSamples, last: float | None) -> RunSamples:
    if last is None or samples.stamps.size == 0:
        return samples
    return samples.since(float(samples.stamps[-1]) - last)


def _message(
    run: ListedRun, samples: RunSamples, other: RunSamples | None, against: int | None, log: RunLog
) -> RunMessage:
    figures, standard = figures_of(samples), log.standard or {}
    assert figures is not None  # it has pictures
    changed = {} if run.recorded else differences(run.parameters, standard)
    compared = None if other is None or run.number == against else difference_of(samples, other)
    difference = None if compared is None else RunDifferenceMessage(**asdict(compared))
    values = asdict(figures)
    if run.recorded:
        values["misleading"] = None
    return RunMessage(
        number=run.number, file=run.file, field=run.place, recorded=run.recorded,
        present=run in log.present, kept=run.kept, parameters=_plain(changed),
        standard=_plain({name: standard[name] for name in changed}),
        units={name: unit for name in changed if (unit := UNITS.get(name))},
        difference=difference, **values,
    )  # fmt: skip


def _plain(parameters: Parameters) -> dict[str, float | str | bool]:
    return {
        name: value if isinstance(value, bool | int | float | str) else str(value)
        for name, value in parameters.items()
    }


def _table(runs: Iterable[RunMessage]) -> str:
    """Return runs as CSV: m, s, and shares."""
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(COLUMNS)
    for run in runs:
        parameters = " ".join(f"{name}={value}" for name, value in run.parameters.items())
        apart = run.difference
        writer.writerow((
            run.number, run.file, run.recorded, run.field, parameters, run.pictures, run.seconds,
            run.rmse, run.median, run.worst, run.lost, run.misleading, run.time_to_right,
            *((apart and (apart.rmse, apart.low, apart.high, apart.paired)) or ("",) * 4),
        ))  # fmt: skip
    return text.getvalue()
