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
        0.5, "What rays that run through walls count, beside where they end; 0 is nothing",
        low=0, high=10,
    )  # fmt: skip
    free_way_sd: float = setting(
        0.1, "Spread of a place on a ray off free cells", unit="m", low=0.01, high=1
    )
    free_way_false: float = setting(
        0.1, "How likely a place on a ray is not free on the map, beside one that is",
        low=0.001, high=1,
    )  # fmt: skip
    free_way_margin: float = setting(
        0.5, "Rays are looked at up to so far before their end", unit="m", low=0, high=5
    )
    global_density: float = setting(
        250.0, "Particles a square metre of free floor when the start is not known", unit="1/m²",
        low=1, high=10_000,
    )  # fmt: skip
    global_most: int = setting(500_000, "But no more than so many", low=1000, high=5_000_000)
    known_share: float = setting(
        0.9, "The robot's place is told once so much of the belief is in one place",
        low=0.1, high=1,
    )  # fmt: skip
    known_sd: float = setting(
        1.0, "And no wider than this along any axis", unit="m", low=0.01, high=10
    )
    known_updates: int = setting(
        8, "After a start anywhere, this has to last for so many measurements", low=1, high=1000
    )
    known_way: float = setting(2.0, "And for so much of a way", unit="m", low=0, high=100)
    tell_above: float = setting(
        -0.75, "Nothing is told while the place explains scans worse, in log-likelihood a ray",
        low=-100, high=0,
    )  # fmt: skip
    doubt_below: float = setting(
        -0.7, "A place that explains scans worse, likewise, gets a rival, and is not told anew",
        low=-100, high=0,
    )  # fmt: skip
    doubt_behind: float = setting(
        4.0, "By which one of two places has to explain them better, summed over measurements",
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
