"""Settings of ``brickpose localize``, for a robot with a laser in a building.

The defaults of the rest of the program are for tape that is seen within a metre; these are for
walls.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.settings.config import by_path, with_settings
from robot.localization.models.motion_models import MotionParameters
from robot.localization.models.sensor_models import SensorParameters
from robot.localization.parameters import FilterParameters, LocalizationParameters
from robot.settings import SettingError, check_settings, describe, setting
from robot.toml_file import read_toml

LASER = LocalizationParameters(
    motion=MotionParameters(alpha1=0.1, alpha2=0.1, alpha3=0.1, alpha4=0.1, alpha5=0.1),
    sensor=SensorParameters(
        sigma_hit=0.2,
        sigma_slope=0.0,
        z_hit=0.9,
        z_rand=0.1,
        z_short=0.1,
        z_max=0.1,
        lambda_short=0.1,
        likelihood_weight=0.1,
        laser_max_range=80.0,
        laser_likelihood_max_dist=1.0,
        beam_skip_distance=0.5,
    ),
    filter=FilterParameters(
        filter="particles",
        refine=False,
        min_particles=1000,
        max_particles=10_000,
        update_min_d=0.2,
        update_min_a=0.2,
        cell_xy=0.5,
        initial_sd_xy=0.5,
        initial_sd_theta=0.25,
    ),
)
"""Names and meanings are those of nav2_amcl, as in the rest of the program."""
UNUSED = ("filter", "refine")
"""Settings of the filter that have no effect here: only the particle filter is used."""


@dataclass(frozen=True)
class LaserSettings:
    """Settings that nav2_amcl does not have."""

    free_way_weight: float = setting(
        0.5, "Weight of rays that run through walls, beside that of their ends; 0 ignores them",
        low=0, high=10,
    )  # fmt: skip
    free_way_sd: float = setting(
        0.1, "Spread of a place on a ray off free cells", unit="m", low=0.01, high=1
    )
    free_way_false: float = setting(
        0.1, "Likelihood of a place on a ray that is not free on the map, relative to a free one",
        low=0.001, high=1,
    )  # fmt: skip
    free_way_margin: float = setting(
        0.5, "Rays are followed up to this distance before their end", unit="m", low=0, high=5
    )
    global_density: float = setting(
        250.0, "Particles for each square metre of free floor if the start is unknown", unit="1/m²",
        low=1, high=10_000,
    )  # fmt: skip
    global_most: int = setting(500_000, "Most particles of such a start", low=1000, high=5_000_000)
    known_share: float = setting(
        0.9, "The place is reported once this share of the belief is in one place",
        low=0.1, high=1,
    )  # fmt: skip
    known_sd: float = setting(
        1.0, "Greatest spread of that place along any axis", unit="m", low=0.01, high=10
    )
    known_updates: int = setting(
        8, "Measurements for which both must hold at first", low=1, high=1000
    )
    known_way: float = setting(
        2.0, "Way for which both must hold at first", unit="m", low=0, high=100
    )
    tell_above: float = setting(
        -0.75, "Least log-likelihood of a ray at which the place is reported",
        low=-100, high=0,
    )  # fmt: skip
    doubt_below: float = setting(
        -0.7, "Below this log-likelihood of a ray, other places are searched for",
        low=-100, high=0,
    )  # fmt: skip
    doubt_behind: float = setting(
        4.0, "Lead in the sum of log-likelihoods by which one of two places wins",
        low=0.1, high=1000,
    )  # fmt: skip

    def __post_init__(self) -> None:
        check_settings(self)


@dataclass(frozen=True)
class LocalizeSettings:
    """All settings, as the tables of a TOML file."""

    localization: LocalizationParameters = LASER
    laser: LaserSettings = LaserSettings()

    def __post_init__(self) -> None:
        if self.localization.filter.filter != "particles":
            raise SettingError(
                f"localization.filter.filter is {self.localization.filter.filter!r}; "
                "valid is particles"
            )


def load_settings(path: Path | None) -> LocalizeSettings:
    """Return the defaults for lasers, overridden by the settings of a TOML file.

    Raises:
        SettingError: the file is missing or not TOML, or a key is misspelt or out of range.
    """
    if path is None:
        return LocalizeSettings()
    table = read_toml(path)
    try:
        return with_settings(LocalizeSettings(), by_path(table))
    except SettingError as error:
        raise SettingError(f"{path}: {error}") from error


def shown_defaults() -> str:
    """Return the text for ``--help``: settings with other defaults here, and those only here."""
    lines = ["settings of a --filter-config, with their defaults for lasers:", ""]
    for group in ("motion", "sensor", "filter"):
        lines.append(f"  [localization.{group}]")
        lines += _shown(getattr(LASER, group), getattr(LocalizationParameters(), group))
    lines.append("  [laser]")
    lines += _shown(LaserSettings(), None)
    return "\n".join(lines)


def _shown(group: Any, usual: Any) -> list[str]:
    lines = []
    for name, known in describe(group).items():
        value = getattr(group, name)
        if name in UNUSED or (usual is not None and value == getattr(usual, name)):
            continue
        unit = f" {known.unit}" if known.unit else ""
        lines.append(f"    {name} = {value}{unit}  # {known.meaning}")
    return lines
