"""``brickpose sweep``: all points of a sweep file, as a table and a plot for each setting."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tqdm import tqdm

from app.batch.workers import Workers
from app.config import Config
from app.sweep.kept import Kept
from app.sweep.plots import plot_setting
from app.sweep.points import Point, Row, duration_of, jobs_of, key_of, points_of
from app.sweep.sweep_file import SweepFile
from app.sweep.table import FORMATS, write_table
from app.sweep.work import MEASURES, Measured, follow_all


@dataclass(frozen=True)
class Swept:
    """What came of a sweep."""

    rows: list[Row]
    done_before: int
    """Points whose results were there already."""


def sweep(
    file: SweepFile, base: Config, workers: Workers, folder: Path, kind: str = "csv"
) -> Swept:
    """Do what is not done yet, and write table and plots.

    Args:
        file: what to sweep.
        base: settings that are not swept.
        workers: who does it.
        folder: for ``results.csv`` (or ``.parquet``), ``plots/``, and ``points/`` with what is
            done; a sweep that was interrupted goes on from there.
        kind: one of ``FORMATS``.

    Raises:
        OSError: the folder cannot be written.
    """
    points = points_of(file, base)
    duration, offset = duration_of(file), file.sweep.offset
    keys = [key_of(point.config, duration, offset) if point.config else "" for point in points]
    configs = {key: point.config for key, point in zip(keys, points, strict=True) if point.config}
    kept = Kept(folder / "points")
    found = {key: one for key in configs if (one := kept.get(key)) is not None}
    done_before = len(found)
    jobs = jobs_of({k: c for k, c in configs.items() if k not in found}, duration, offset)
    with tqdm(total=len(configs), initial=done_before, unit="point", disable=None) as progress:
        for place, outcome in workers.each(follow_all, jobs):
            for key in jobs[place].configs:
                found[key] = _of(outcome, key)
                # A worker's end may be the machine's fault: the next time it is tried again.
                if not isinstance(outcome, Exception):
                    kept.put(key, found[key])
                progress.update()
    rows = [_row(point, found.get(key)) for point, key in zip(points, keys, strict=True)]
    write_table(folder / f"results.{kind}", rows)
    for other in FORMATS:
        if other != kind:
            (folder / f"results.{other}").unlink(missing_ok=True)
    for setting in file.values:
        plot_setting(folder / "plots" / f"{setting}.svg", setting, rows)
    return Swept(rows, done_before)


def _of(outcome: dict[str, Measured] | Exception, key: str) -> Measured:
    if isinstance(outcome, Exception):
        return dict.fromkeys(MEASURES) | {"error": str(outcome) or type(outcome).__name__}
    return outcome[key]


def _row(point: Point, measured: Measured | None) -> Row:
    about = point.settings | {"world": point.world, "seed": point.seed}
    if measured is None:
        measured = dict.fromkeys(MEASURES) | {"error": point.error}
    return about | measured
