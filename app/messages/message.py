"""Base class and common types of all messages."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

Layer = Literal["particles", "headings", "rays", "covariance", "paths", "truth", "camera"]
Metres = Annotated[float, Field(ge=-1e4, le=1e4)]
Radians = Annotated[float, Field(ge=-1e3, le=1e3)]


class Message(BaseModel):
    """Base of all messages: frozen, with finite numbers, and without unknown keys."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True
    )
