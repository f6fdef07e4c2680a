"""Base class and common types of all messages."""

from __future__ import annotations

import ast
import inspect
import textwrap
from functools import cache
from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

LONGEST_ID = 200
"""Longest id of a command [characters]; the answer repeats it."""


Layer = Literal["particles", "headings", "rays", "covariance", "paths", "truth", "camera"]
Metres = Annotated[float, Field(ge=-1e4, le=1e4)]
Radians = Annotated[float, Field(ge=-1e3, le=1e3)]


def _describe(schema: dict[str, Any], message: type[BaseModel]) -> None:
    """Add what stands below a message's attributes, when its schema is asked for.

    pydantic itself would read the source code of each message at each start.
    """
    described = schema.get("properties", {})
    for kind in reversed(message.__mro__):
        for name, words in _docs_of(kind) if issubclass(kind, Message) else ():
            if name in described:
                described[name]["description"] = words


@cache
def _docs_of(message: type[BaseModel]) -> tuple[tuple[str, str], ...]:
    """Return the attributes that a class itself defines, with what stands below each."""
    try:
        source = textwrap.dedent(inspect.getsource(message))
    except OSError:  # typed at a prompt
        return ()
    (definition,) = ast.parse(source).body
    docs = []
    for pair in pairwise(vars(definition)["body"]):
        match pair:
            case ast.AnnAssign(target=ast.Name(name)), ast.Expr(value=ast.Constant(str(words))):
                docs.append((name, inspect.cleandoc(words)))
    return tuple(docs)


class Message(BaseModel):
    """Base of all messages: frozen, with finite numbers, and without unknown keys."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, allow_inf_nan=False, json_schema_extra=_describe
    )


def _short(name: int | str | None) -> int | str | None:
    if isinstance(name, str) and len(name) > LONGEST_ID:
        raise ValueError(f"an id has at most {LONGEST_ID} characters")
    return name


class CommandMessage(Message):
    """Base of all commands; a number must be a number, not a text or a truth value."""

    model_config = ConfigDict(strict=True)

    id: Annotated[int | str | None, AfterValidator(_short)] = None
    """Repeated in the answer."""
    sent: float | None = None
    """The robot's clock when it was sent [s], as answers tell it. A drive command that has come
    half a second late or more is refused, if it says so: somebody may have stopped the robot."""

    @property
    def kind(self) -> str:
        """The word that tells it from other commands: its ``type`` on the wire."""
        word: str = vars(self)["type"]
        return word
