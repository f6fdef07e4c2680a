"""FilterKind, a filter that the parameters can name; ``FILTERS`` has those on offer."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pkgutil import resolve_name
from typing import TYPE_CHECKING

from robot.hooks import added

if TYPE_CHECKING:
    import numpy as np

    from robot.localization.filter import Filter, Setup


@dataclass(frozen=True)
class FilterKind:
    """A filter by its name. Parameters of what it does not use are shown as idle."""

    name: str
    """The value of the parameter ``filter``."""
    maker: str
    """``package.module:function``, imported at the first use: it takes a ``Setup`` and a random
    generator, and returns a ``Filter`` at the field's start pose."""
    has_particles: bool = False
    has_hypotheses: bool = False
    """Whether it searches for places and follows several."""
    has_sensor_model: bool = True
    """Whether it asks the sensor model; one that lays rays on edges does not."""

    def make(self, setup: Setup, rng: np.random.Generator) -> Filter:
        """Return a filter at the field's start pose."""
        made: Filter = resolve_name(self.maker)(setup, rng)
        return made


OURS = (
    FilterKind(
        "hypotheses",
        "robot.localization.hypotheses.multi_hypothesis:MultiHypothesisFilter.of",
        has_particles=True,
        has_hypotheses=True,
    ),
    FilterKind(
        "particles",
        "robot.localization.particles.particle_filter:ParticleFilter.of",
        has_particles=True,
    ),
    FilterKind(
        "kalman", "robot.localization.kalman_filter:KalmanFilter.of", has_sensor_model=False
    ),
)


class _Filters(Mapping[str, FilterKind]):
    """The filters on offer; features are asked only where ours are not enough."""

    def __contains__(self, name: object) -> bool:
        return name in _OURS or name in self._all

    def __getitem__(self, name: str) -> FilterKind:
        return _OURS[name] if name in _OURS else self._all[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._all)

    def __len__(self) -> int:
        return len(self._all)

    def __bool__(self) -> bool:
        return True

    @property
    def _all(self) -> dict[str, FilterKind]:
        return _OURS | {kind.name: kind for kind in added().filters}


_OURS = {kind.name: kind for kind in OURS}
FILTERS = _Filters()
"""What the parameter ``filter`` chooses from: ours, and those that features add."""
