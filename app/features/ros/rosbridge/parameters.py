"""The filter's parameters by rosapi, as roslibjs's ``Param`` asks for them.

A parameter of ROS 2 is named by node and name (``/brickpose:alpha1``), one of ROS 1 as a path
(``/brickpose/alpha1``); either will do, and the bare name, too. Values are JSON in a text.
"""

from __future__ import annotations

import dataclasses
import json
from typing import Any

from pydantic import ValidationError

from app.engine.driver import Driver
from app.features.ros.inbox import Inbox
from app.features.ros.message_types import MessageError
from app.features.ros.rosbridge.reading import shown
from app.messages.commands import SetParametersCommand, in_words
from robot.settings import describe

Answer = dict[str, Any]
DONE: Answer = {"successful": True, "reason": ""}


class RosParameters:
    """The parameters by their names in ROS."""

    def __init__(self, inbox: Inbox, node: str) -> None:
        """``node``: the name of the program's node, with its namespace."""
        self._inbox = inbox
        self._node = node

    def names(self) -> list[str]:
        """The names, as ROS 2 has them."""
        return [f"{self._node}:{name}" for name in sorted(self._values())]

    def get(self, name: str, default: str | None = None) -> Answer:
        """Return a value; of an unknown name the default.

        Raises:
            MessageError: the name is unknown, and there is no default.
        """
        values, bare = self._values(), self._bare(name)
        if bare in values:
            return {"value": json.dumps(values[bare]), **DONE}
        if default:
            return {"value": default, **DONE}
        raise MessageError(self._unknown(name))

    def has(self, name: str) -> bool:
        """Whether there is such a parameter."""
        return self._bare(name) in self._values()

    def full_name(self, name: str) -> str:
        """The name as ROS 2 has it; empty if there is no such parameter."""
        return f"{self._node}:{self._bare(name)}" if self.has(name) else ""

    def set(self, name: str, value: Any, driver: Driver) -> Answer:
        """Change a parameter.

        Args:
            value: JSON in a text; a number or a truth value may stand there itself.

        Raises:
            MessageError, CommandError: the name is unknown or the value invalid; says what is
                valid.
        """
        bare = self._bare(name)
        if bare not in self._values():
            raise MessageError(self._unknown(name))
        given = _value(value)
        if isinstance(given, str) and ":" in given:
            raise MessageError(f"{name} is {shown(given)}: the page alone chooses files of Python")
        try:
            command = SetParametersCommand(type="set_parameters", values={bare: given})
        except ValidationError as error:
            raise MessageError(f"{name} is {shown(value)}: {in_words(error)}") from error
        self._inbox.carry_out(command, driver)
        return dict(DONE)

    def _values(self) -> dict[str, Any]:
        groups = self._inbox.parameters()
        return {
            name: getattr(group, name)
            for group in (getattr(groups, item.name) for item in dataclasses.fields(groups))
            for name in describe(group)
        }

    def _bare(self, name: str) -> str:
        node, colon, bare = name.rpartition(":")
        if not colon:
            node, _, bare = name.lstrip("/").rpartition("/")
        return bare if node.strip("/") in ("", self._node.strip("/")) else name

    def _unknown(self, name: str) -> str:
        return f"{name} is no parameter; valid are {', '.join(self.names())}"


def _value(value: Any) -> Any:
    """Return what a text means in JSON; a word without quotes means itself."""
    if not isinstance(value, str):
        return value
    try:
        return json.loads(value)
    except (ValueError, RecursionError):
        return value
