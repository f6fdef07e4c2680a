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

    predict: move the particles by odometry up to the newest picture, with noise. weigh: weigh them
    by that picture. resample: draw the particles that survive. Each follows the one before it;
    predict is always possible.
    """

    type: Literal["filter_step"]
    step: Literal["predict", "weigh", "resample"]


class FilterUndoCommand(CommandMessage):
    """Take back the last step by hand, random numbers included."""

    type: Literal["filter_undo"]
