"""The report of the models' statistics: one page that opens without a network."""

from __future__ import annotations

from typing import Any

from app.lab.evaluation.report.report import embedded, page
from app.lab.model_fits.motion_statistics import MotionStatistics
from app.lab.model_fits.report.models_figures import motion_ends, range_errors, regions_held
from app.lab.model_fits.sensor_statistics import SensorStatistics
from app.settings.config import Config
from app.settings.provenance import settings_of

TEMPLATE = "models.html.jinja"


def models_report(
    results: dict[str, Any],
    motion: MotionStatistics,
    sensor: SensorStatistics | None,
    config: Config,
) -> str:
    """The page."""
    default = settings_of(config)
    return page(
        TEMPLATE,
        experiment=results["experiment"],
        results=results,
        default={path: default[path] for path in results["fitted"]},
        ends=embedded(motion_ends(motion.ends)) if motion.ends else None,
        regions=embedded(regions_held(motion.held)) if motion.held else None,
        ranges=embedded(range_errors(sensor)) if sensor else None,
        settings=default,
    )
