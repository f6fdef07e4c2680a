"""FilterKind, a filter that the parameters can name; ``FILTERS`` has those on offer."""

from __future__ import annotations

from dataclasses import dataclass
from pkgutil import resolve_name
from typing import TYPE_CHECKING

from robot.hooks import Offered, added

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


OURS = {
    kind.name: kind
    for kind in (
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
    )
}
FILTERS = Offered(OURS, lambda: OURS | {kind.name: kind for kind in added().filters})
"""What the parameter ``filter`` chooses from: ours, and those that features add."""
