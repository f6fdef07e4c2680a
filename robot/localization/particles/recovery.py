"""When to try elsewhere: random particles, the more the worse scans fit lately."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robot.geometry import Array


@dataclass
class Recovery:
    """Augmented MCL (Probabilistic Robotics, Table 8.3; nav2_amcl's recovery_alpha).

    Two running averages of how likely the scans are; where the fast one falls below the slow one,
    1 - fast / slow of the particles are drawn anew from anywhere.
    """

    slow: float = 0.0
    fast: float = 0.0

    def observe(
        self, log_likelihood: Array, weights: Array, rays: int, alpha_slow: float, alpha_fast: float
    ) -> None:
        """Take the average likelihood of a scan over particles with weights (n,) into account.

        It is that of one ray, the geometric mean over them: so scans with few rays and with many
        compare, and no single one outweighs all the others.

        Args:
            log_likelihood: (n,) of the whole scan.
            weights: (n,) from before it, summing to one.
            rays: how many the log-likelihood is the sum of.
            alpha_slow: share of the new value in the slow average; 0 is never to try elsewhere.
            alpha_fast: the same of the fast one.
        """
        if alpha_slow == 0 or alpha_fast == 0:
            return
        average = float(weights @ np.exp(log_likelihood / max(rays, 1)))
        self.slow += (alpha_slow if self.slow else 1.0) * (average - self.slow)
        self.fast += (alpha_fast if self.fast else 1.0) * (average - self.fast)

    def share(self) -> float:
        """Which share of the particles is to be drawn anew."""
        return max(0.0, 1.0 - self.fast / self.slow) if self.slow > 0 else 0.0
