"""The filter by hand, forwards and back, while it does nothing by itself."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from app.engine.earlier_beliefs import EarlierBeliefs
from robot.geometry import Pose2
from robot.localization.estimate import Belief
from robot.localization.filter import Cloud
from robot.localization.filter_by_hand import FilterByHand, HandStep, Step, StepError
from robot.localization.localizer import Localizer
from robot.localization.particles.resampling import effective_sample_size
from robot.scan import Scan

MOST_STEPS = 60
"""Most steps back."""


@dataclass(frozen=True, slots=True)
class HandState:
    """How far the filter is by hand."""

    number: int
    """Another one after each step, forwards or back."""
    undoable: int
    """How many steps can be taken back."""
    last: HandStep | None
    """The last step; None before the first."""
    particles: Cloud = field(repr=False)
    """As they stand."""
    ahead: Pose2
    """Motion by odometry since the last prediction."""

    @property
    def effective(self) -> float:
        """Effective sample size of the particles as they stand."""
        return effective_sample_size(self.particles.weights)


class StepsByHand:
    """Takes steps, and takes them back; while it is switched off, the filter works by itself."""

    def __init__(self) -> None:
        self._filter: FilterByHand | None = None
        self._earlier = EarlierBeliefs(MOST_STEPS)
        self._number = 0
        self._taken_back: list[tuple[Scan, Pose2]] = []
        """Scans of predictions that were taken back, the next one last: on a robot that stands, the
        same steps do the same again."""

    @property
    def enabled(self) -> bool:
        """Whether the filter waits for steps."""
        return self._filter is not None

    @property
    def seen(self) -> tuple[Scan, Pose2] | None:
        """The scan at which the particles are since the last prediction, and odometry there."""
        return None if self._filter is None else self._filter.seen

    @property
    def particles(self) -> Cloud | None:
        """As they stand; None while it is switched off."""
        return None if self._filter is None else self._filter.particles

    def state(self, odometry: Pose2 | None) -> HandState | None:
        """Return how far it is, with odometry at the newest scan; None while switched off."""
        by_hand = self._filter
        if by_hand is None:
            return None
        ahead = Pose2() if odometry is None else by_hand.localizer.moved(odometry)
        number, undoable = self._number, len(self._earlier)
        return HandState(number, undoable, by_hand.last, by_hand.particles, ahead)

    def switch(self, localizer: Localizer | None) -> None:
        """Begin with the filter of a localizer; None lets the filter work by itself again.

        Raises:
            StepError: the filter is no particle filter.
        """
        self._filter = None if localizer is None else FilterByHand(localizer)
        self._earlier.clear()
        self._taken_back.clear()
        self._number += 1

    def restart(self, localizer: Localizer) -> None:
        """Begin anew if it is switched on: the belief is another one now."""
        if self.enabled:
            self.switch(localizer)

    def step(
        self,
        step: Step,
        newest: tuple[Scan, Pose2] | None,
        belief: tuple[Any, ...],
        unchanging: tuple[Any, ...],
    ) -> Belief | None:
        """Take a step, and keep what was before it.

        Args:
            step: which one.
            newest: the newest scan, and odometry at its stamp; None before the first.
            belief: what to keep.
            unchanging: what of it never changes.

        Returns:
            The new belief; None if it stays as it is.

        Raises:
            StepError: it is switched off, or this is not the time for the step.
        """
        by_hand = self._filter
        if by_hand is None:
            raise StepError("the filter works by itself; switch filter_by_hand on first")
        kept = self._earlier.copy((*belief, by_hand), unchanging)
        result = self._take(by_hand, step, newest)
        self._earlier.add(kept)
        self._number += 1
        return result

    def undo(self) -> tuple[Any, ...]:
        """Return what was kept before the last step.

        Raises:
            StepError: there is nothing to take back.
        """
        if not self.enabled or not len(self._earlier):
            raise StepError("there is no step by hand to take back")
        last = self._filter
        *belief, self._filter = self._earlier.restore()
        if last is not None and last.last is not None and last.last.newest is not None:
            self._taken_back.append(last.last.newest)
        self._number += 1
        return tuple(belief)

    def _take(
        self, by_hand: FilterByHand, step: Step, newest: tuple[Scan, Pose2] | None
    ) -> Belief | None:
        if step == "resample":
            by_hand.resample()
            return None
        if step == "weigh":
            estimate = by_hand.weigh()
            assert by_hand.seen is not None  # else it was refused
            return None if estimate is None else Belief(estimate, by_hand.seen[1])
        if newest is None:
            raise StepError("there is no scan yet; the camera has sent no picture")
        by_hand.predict(*self._repeated(newest))
        return None

    def _repeated(self, newest: tuple[Scan, Pose2]) -> tuple[Scan, Pose2]:
        """Return the scan of the prediction that was taken back here, or the newest."""
        if self._taken_back and self._taken_back[-1][1] == newest[1]:
            return self._taken_back.pop()
        self._taken_back.clear()
        return newest
