"""Stages of the start of a Build HAT."""

from __future__ import annotations

from enum import Enum


class Stage(Enum):
    """A stage of the start; its value is the text that users see."""

    ASKING = "asking which firmware runs"
    CLEARING = "preparing the upload of the firmware"
    LOADING = "sending the firmware, which takes five seconds"
    SIGNING = "sending the firmware's signature"
    REBOOTING = "starting the firmware"
    PAUSING = "waiting for quiet before the firmware is sent again"
    RESETTING = "resetting the board"
    LISTING = "asking what is at the ports"
    RUNNING = "running"
    FAILED = "waiting before the next try"
