"""The bridge that all clients of rosbridge share; rosapi's services: topics, types and services."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from app.engine.driver import Driver
from app.features.ros.inbox import Inbox
from app.features.ros.incoming import Service
from app.features.ros.message_types import Message, MessageError, definition, typestore
from app.features.ros.publisher import TopicPublisher
from app.features.ros.rosbridge.actions import ACTIONS, Action
from app.features.ros.rosbridge.encoding import Encoder
from app.features.ros.rosbridge.names import (
    NUMBERS,
    FieldType,
    Names,
    fields,
    full_type,
    spellings,
)
from app.features.ros.rosbridge.parameters import RosParameters
from app.features.ros.rosbridge.reading import message_of, shown

PACKAGE = "rosapi"
SECOND_NS = 1_000_000_000
GET_PARAM, SET_PARAM = PARAMETERS = ("get_param", "set_param")

Answer = dict[str, Any]
ONE = -1
"""The array length of a field that is not an array."""


class RosApi:
    """Answers the services of rosapi from the list of names."""

    def __init__(self, names: Names, inbox: Inbox) -> None:
        self._names = names
        self._node = names.settings.full_name("brickpose")
        self._parameters = RosParameters(inbox, self._node)
        self._plain: dict[str, Callable[[], Answer]] = {
            "topics": self._topics,
            "topics_and_raw_types": self._topics_and_raw_types,
            "services": lambda: {"services": [*names.service_types(), *self.names()]},
            "nodes": lambda: {"nodes": [self._node]},
            "get_time": _get_time,
            "get_ros_version": lambda: {"version": 2, "distro": "jazzy"},
            "get_param_names": lambda: {"names": self._parameters.names()},
            "action_servers": lambda: {
                "action_servers": [names.settings.full_name(action.name) for action in ACTIONS]
            },
        }
        self._with_one: dict[str, tuple[str, Callable[[str], Answer]]] = {
            "topic_type": ("topic", self._topic_type),
            "topics_for_type": ("type", self._topics_for_type),
            "service_type": ("service", self._service_type),
            "services_for_type": ("type", self._services_for_type),
            "service_node": ("service", lambda service: {"node": self._node}),
            "node_details": ("node", self._node_details),
            "publishers": ("topic", lambda topic: self._nodes("publishers", topic, names.outgoing)),
            "subscribers": (
                "topic",
                lambda topic: self._nodes("subscribers", topic, names.incoming),
            ),
            "has_param": ("name", lambda name: {"exists": self._parameters.has(name)}),
            "search_param": (
                "name",
                lambda name: {"global_name": self._parameters.full_name(name)},
            ),
            "message_details": ("type", _message_details),
            "service_request_details": ("type", lambda name: _service_details(name, "Request")),
            "service_response_details": ("type", lambda name: _service_details(name, "Response")),
        }

    def names(self) -> list[str]:
        """The names of its services, with a leading slash."""
        return sorted(f"/{PACKAGE}/{name}" for name in (*self._plain, *self._with_one, *PARAMETERS))

    def call(self, service: str, arguments: Any) -> Answer | None:
        """Return the answer of a service; None if the service is not one of rosapi.

        Raises:
            MessageError: rosapi has no such service, or the arguments do not fit it.
        """
        package, _, name = service.lstrip("/").partition("/")
        if package != PACKAGE:
            return None
        if name in self._plain:
            return self._plain[name]()
        if name == GET_PARAM:
            default = _given(arguments, ("name", "default_value")).get("default_value")
            default = default if isinstance(default, str) else None
            return self._parameters.get(_text(arguments, "name"), default)
        if name not in self._with_one:
            raise MessageError(f"{service} is no service; valid are {', '.join(self.names())}")
        argument, answer = self._with_one[name]
        return answer(_text(arguments, argument))

    def set_parameter(self, arguments: Any, driver: Driver) -> Answer:
        """Change a parameter of the filter, as the service ``set_param`` does.

        Raises:
            MessageError, CommandError: it is unknown or not allowed; says what is valid.
        """
        given = _given(arguments, ("name", "value"))
        return self._parameters.set(_text(arguments, "name"), given.get("value"), driver)

    def _topics(self) -> Answer:
        types = self._names.topic_types()
        return {"topics": list(types), "types": list(types.values())}

    def _topics_and_raw_types(self) -> Answer:
        answer = self._topics()
        return {**answer, "typedefs_full_text": [definition(name) for name in answer["types"]]}

    def _topic_type(self, topic: str) -> Answer:
        full = self._names.settings.full_name(self._names.plain(topic))
        return {"type": self._names.topic_types().get(full, "")}

    def _topics_for_type(self, name: str) -> Answer:
        wanted = full_type(name, "msg")
        types = self._names.topic_types()
        return {"topics": [topic for topic, its in types.items() if its == wanted]}

    def _service_type(self, service: str) -> Answer:
        result = self._names.service(service)
        return {"type": result.type if result else ""}

    def _services_for_type(self, name: str) -> Answer:
        wanted = full_type(name, "srv")
        types = self._names.service_types()
        return {"services": [service for service, its in types.items() if its == wanted]}

    def _node_details(self, node: str) -> Answer:
        full = self._names.settings.full_name
        ours = node == self._node
        return {
            "subscribing": [full(name) for name in self._names.incoming] if ours else [],
            "publishing": [full(name) for name in self._names.outgoing] if ours else [],
            "services": [full(name) for name in self._names.services] if ours else [],
        }

    def _nodes(self, key: str, topic: str, known: dict[str, Any]) -> Answer:
        return {key: [self._node] if self._names.plain(topic) in known else []}


def _get_time() -> Answer:
    sec, nanosec = divmod(time.time_ns(), SECOND_NS)
    # Also under the names of ROS 1, which roslibpy reads.
    return {"time": {"sec": sec, "nanosec": nanosec, "secs": sec, "nsecs": nanosec}}


def _message_details(name: str) -> Answer:
    return {"typedefs": type_details(full_type(name, "msg"))}


def _service_details(name: str, half: str) -> Answer:
    return {"typedefs": type_details(f"{full_type(name, 'srv')}_{half}")}


def _text(arguments: Any, name: str) -> str:
    """Return the only argument, given by its name or as a list of one."""
    value = _given(arguments, (name,)).get(name)
    if not isinstance(value, str):
        raise MessageError(f"{name} is {shown(value)}; valid is a text")
    return value


def _given(arguments: Any, names: tuple[str, ...]) -> dict[str, Any]:
    """Return arguments by their names; a list has them in order."""
    if isinstance(arguments, list):
        return dict(zip(names, arguments, strict=False))
    return arguments if isinstance(arguments, dict) else {}


def type_details(type_name: str) -> list[dict[str, Any]]:
    """Describe a type and all types in it, each once, beginning with the type itself.

    Raises:
        MessageError: the type is unknown.
    """
    result: dict[str, dict[str, Any]] = {}
    waiting = [type_name]
    while waiting:
        name = waiting.pop(0)
        if name not in result:
            result[name] = _details(name)
            waiting += [kind.name for kind in fields(name).values() if kind.nested]
    return list(result.values())


def _details(name: str) -> dict[str, Any]:
    kinds = fields(name)
    constants = typestore().fielddefs[name][0]
    return {
        "type": name,
        "fieldnames": list(kinds),
        "fieldtypes": [kind.name for kind in kinds.values()],
        "fieldarraylen": [kind.length if kind.many else ONE for kind in kinds.values()],
        "examples": [_example(kind) for kind in kinds.values()],
        "constnames": [constant[0] for constant in constants],
        "constvalues": [str(constant[2]) for constant in constants],
    }


def _example(kind: FieldType) -> str:
    if kind.many:
        return "[]"
    if kind.nested:
        return "{}"
    return str(NUMBERS[kind.name].type(0).item()) if kind.name in NUMBERS else ""


class Bridge:
    """One robot, as all clients see it."""

    def __init__(self, publisher: TopicPublisher, inbox: Inbox) -> None:
        self.publisher = publisher
        self.inbox = inbox
        self.names = Names(inbox)
        self.rosapi = RosApi(self.names, inbox)
        self.encoder = Encoder()

    def service(self, name: str) -> Service:
        """Return a service that a client calls.

        Raises:
            MessageError: there is no service of that name; lists the valid names.
        """
        result = self.names.service(name)
        if result is None:
            valid = ", ".join([*self.names.service_types(), *self.rosapi.names()])
            raise MessageError(f"{name} is no service; valid are {valid}")
        return result

    def action(self, name: str) -> Action:
        """Return the action of that name.

        Raises:
            MessageError: there is none; lists the valid names.
        """
        for action in ACTIONS:
            if name in spellings(action.name, self.names.settings):
                return action
        valid = ", ".join(self.names.settings.full_name(action.name) for action in ACTIONS)
        raise MessageError(f"{name} is no action; valid are {valid}")

    def request_of(self, service: Service, arguments: Any) -> Message:
        """Make a request from its arguments: fields by name, or a list in the order of the fields.

        Raises:
            MessageError: the arguments do not fit the service.
        """
        type_name = f"{service.type}_Request"
        if isinstance(arguments, list):
            names = list(fields(type_name))
            if len(arguments) > len(names):
                raise MessageError(f"{service.name} takes {len(names)} arguments")
            arguments = dict(zip(names, arguments, strict=False))
        return message_of(arguments, type_name)
