"""NavigationStatus: what a journey shows of itself, and in which state it is."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from robot.geometry import Array, Pose2
from robot.navigation.goal import Goal

NavigationState = Literal["planning", "driving", "waiting", "arrived", "canceled", "failed"]


@dataclass(frozen=True, eq=False)
class NavigationStatus:
    """What navigation shows of itself."""

    state: NavigationState
    goals: tuple[Goal, ...]
    name: str | int | None = None
    """By which its sender knows it."""
    number: int = 0
    """Number of the goal that it drives to, from 0."""
    reason: str = ""
    """Why it stands or has failed, or how well it knows only that it has arrived, in words for
    people; empty while all is well."""
    remaining_m: float = 0.0
    """The way to this goal [m]."""
    remaining_s: float = 0.0
    """How long it takes to this goal [s]."""
    target: Pose2 | None = None
    """Where the robot shall be next."""
    path: Array | None = field(default=None, repr=False)
    """(n, 2) the way to this goal [m]."""
    planned: float = 0.0
    """When that way was taken [s]: another one has another time."""
    began: float = 0.0
    """When the journey began [s]: another one has another time."""
    since: float = 0.0
    """Since when it is in this state [s]."""
    on_curve: bool = False
    """Whether it drives along a closed curve, or to it; then there are no goals."""

    @property
    def active(self) -> bool:
        """Whether the robot drives, or will."""
        return self.state in ("planning", "driving", "waiting")
