"""Configuration of the DDS process: domain, reach, and the topics that it writes and reads."""

from __future__ import annotations

import contextlib
import ipaddress
import os
from collections.abc import Iterable, Mapping
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from app.features.ros.dds.protocol import Endpoint, Kind, Plan, Shapes
from app.features.ros.incoming import IncomingTopic
from app.features.ros.message_types import type_hash, typestore
from app.features.ros.topics import topics
from app.settings.groups import Ros2Settings
from robot.errors import BrickPoseError

NODE = "brickpose"
MOST_DOMAIN = 232
"""The highest domain: DDS has no ports for more."""
NEWEST_COUNTS = ("cmd_vel",)
"""Topics read with best effort, which matches any publisher: a new message beats a late one."""
URI = "CYCLONEDDS_URI"
"""Environment variable of Cyclone DDS's own configuration: if it is set, it takes precedence."""
LOOPBACK = "<Interfaces><NetworkInterface address='127.0.0.1'/></Interfaces>"
NEVER_PRUNED = (
    "<InitialLocatorPruneDelay>inf</InitialLocatorPruneDelay>"
    "<DiscoveredLocatorPruneDelay>inf</DiscoveredLocatorPruneDelay>"
)
"""Keeps addresses that were silent for long: a participant may come to them at any time."""
ALONE = (
    "<CycloneDDS><Domain Id='any'><General>" + LOOPBACK + "<AllowMulticast>false</AllowMulticast>"
    # Loopback takes a whole picture at once; at Ethernet's size it would be 24 packets per reader.
    "<MaxMessageSize>65000B</MaxMessageSize><FragmentSize>64000B</FragmentSize></General>"
    # Loopback has no multicast, so this process announces itself to each participant on this
    # machine, and repeats it often: late participants learn of it only then.
    "<Discovery><ParticipantIndex>auto</ParticipantIndex><SPDPInterval>1s</SPDPInterval>"
    "<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>"
    + NEVER_PRUNED
    + "<Peers><Peer address='127.0.0.1'/></Peers></Discovery>"
    "</Domain></CycloneDDS>"
)
"""Configuration for this machine only."""
ALONE_BEFORE_11 = ALONE.replace(LOOPBACK, "").replace(NEVER_PRUNED, "")
"""The same for Cyclone DDS 0.10, which a Pi has. It prunes no addresses. It goes without the
loopback interface: from there, it does not reach participants that announce other addresses of
this machine. Its sockets are bound to the loopback device all the same."""
ONE_ADDRESS = (
    "<CycloneDDS><Domain Id='any'><General><Interfaces>"
    "<NetworkInterface address='{}'/></Interfaces></General></Domain></CycloneDDS>"
)


def shapes(type_names: Iterable[str]) -> Shapes:
    """Return the fields of message types and of all types in them, contained types first."""
    result: Shapes = {}
    for name in type_names:
        _add(name, result)
    return result


def _add(name: str, result: Shapes) -> None:
    if name not in result:
        _, fields = typestore().fielddefs[name]
        result[name] = [(field, _kind(described, result)) for field, described in fields]


def _kind(described: Any, result: Shapes) -> Kind:
    """Convert a field's type as rosbags describes it: (form, content)."""
    form, item_type = described
    match form.name:
        case "BASE":
            return str(item_type[0])
        case "NAME":
            _add(item_type, result)
            return str(item_type)
        case _:
            inner, size = item_type
            return [_kind(inner, result), form.name.lower(), size]


class DomainError(BrickPoseError, ValueError):
    """The domain is not a valid domain of DDS."""


def domain(settings: Ros2Settings, environment: Mapping[str, str]) -> int:
    """Return the domain to join.

    Raises:
        DomainError: ROS_DOMAIN_ID is not a valid domain.
    """
    if settings.domain_id >= 0:
        return settings.domain_id
    text = environment.get("ROS_DOMAIN_ID", "") or "0"
    if not (text.isascii() and text.isdigit() and int(text) <= MOST_DOMAIN):
        raise DomainError(f"ROS_DOMAIN_ID is {text!r}; valid are 0 to {MOST_DOMAIN}")
    return int(text)


def alone() -> str:
    """The configuration for this machine only, for the installed version of Cyclone DDS."""
    with contextlib.suppress(PackageNotFoundError):
        if version("cyclonedds").startswith("0."):
            return ALONE_BEFORE_11
    return ALONE


def reach(host: str, environment: Mapping[str, str]) -> tuple[str | None, bool]:
    """Return Cyclone DDS's configuration, and whether to keep other machines out.

    Both follow the address that the page listens on. A configuration of None leaves Cyclone DDS to
    its own environment variable and defaults.
    """
    if environment.get(URI):
        return None, False
    try:
        address = ipaddress.ip_address(host)
    except ValueError:
        return (alone(), True) if host == "localhost" else (None, False)
    if address.is_loopback:
        return alone(), True
    whole = address.is_unspecified or address.version == 6
    return (None if whole else ONE_ADDRESS.format(address)), False


def plan(
    settings: Ros2Settings,
    host: str,
    incoming: Iterable[IncomingTopic],
    environment: Mapping[str, str] | None = None,
) -> Plan:
    """Return everything that the process needs to know.

    Args:
        settings: names and domain.
        host: the address that the page listens on; DDS has the same reach.
        incoming: the topics of the commands to read.
        environment: environment variables; those of this program by default.

    Raises:
        DomainError: ROS_DOMAIN_ID is not a valid domain.
    """
    environment = os.environ if environment is None else environment
    configuration, confined = reach(host, environment)
    writers = [
        Endpoint(
            settings.full_name(topic.name),
            topic.type,
            type_hash(topic.type),
            topic.quality.reliable,
            topic.quality.latched,
            topic.quality.depth,
        )
        for topic in topics()
        if topic.live
    ]
    readers = [
        Endpoint(
            settings.full_name(each.name),
            each.type,
            type_hash(each.type),
            reliable=each.name not in NEWEST_COUNTS,
        )
        for each in incoming
    ]
    return Plan(
        domain=domain(settings, environment),
        namespace=settings.full_name(""),
        name=NODE,
        configuration=configuration,
        confined=confined,
        shapes=shapes(item.type for item in (*writers, *readers)),
        writers=tuple(writers),
        readers=tuple(readers),
    )
