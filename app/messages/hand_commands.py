"""Commands to step the particle filter by hand."""

from __future__ import annotations

from typing import Literal

from app.messages.message import CommandMessage


class FilterByHandCommand(CommandMessage):
    """Let the particle filter wait for steps by hand, or work by itself again.

    Odometry gathers meanwhile; the next prediction uses all of it.
    """

    type: Literal["filter_by_hand"]
    on: bool


class FilterStepCommand(CommandMessage):
    """Take one step of the particle filter by hand.

    predict: move the particles by odometry up to the newest picture, and by chance. weigh: weigh
    them by that picture. resample: draw those that go on. Each is possible after the one before it,
    and predict always.
    """

    type: Literal["filter_step"]
    step: Literal["predict", "weigh", "resample"]


class FilterUndoCommand(CommandMessage):
    """Take back the last step by hand: all is as before it, the random numbers to come, too."""

    type: Literal["filter_undo"]


HandCommand = FilterByHandCommand | FilterStepCommand | FilterUndoCommand
