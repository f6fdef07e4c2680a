"""Where the DDS process takes part: domain, reach, and what it publishes and hears."""

from __future__ import annotations

import contextlib
import ipaddress
import os
from collections.abc import Iterable, Mapping
from importlib.metadata import PackageNotFoundError, version

from app.ros2.commands.incoming import IncomingTopic
from app.ros2.dds.plan import Endpoint, Plan
from app.ros2.dds.shapes import shapes
from app.ros2.message_types import type_hash
from app.ros2.topics import TOPICS
from app.settings.ros2 import Ros2Settings

NODE = "brickpose"
MOST_DOMAIN = 232
"""DDS has no ports for more."""

NEWEST_COUNTS = ("cmd_vel",)
"""Heard with best effort, which matches any publisher: the next message beats a late one."""

URI = "CYCLONEDDS_URI"
"""Cyclone DDS's own configuration: who sets it has the say."""

LOOPBACK = "<Interfaces><NetworkInterface address='127.0.0.1'/></Interfaces>"

ALONE = (
    "<CycloneDDS><Domain Id='any'><General>" + LOOPBACK + "<AllowMulticast>false</AllowMulticast>"
    # Loopback takes a whole picture at once; as for Ethernet it would be 24 packets a reader.
    "<MaxMessageSize>65000B</MaxMessageSize><FragmentSize>64000B</FragmentSize></General>"
    # Loopback knows no multicast, so participants of this machine are told one by one, and often:
    # who comes later hears of us only then.
    "<Discovery><ParticipantIndex>auto</ParticipantIndex><SPDPInterval>1s</SPDPInterval>"
    "<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>"
    "<Peers><Peer address='127.0.0.1'/></Peers></Discovery>"
    "</Domain></CycloneDDS>"
)
"""Only this machine."""

ALONE_BEFORE_11 = ALONE.replace(LOOPBACK, "")
"""Cyclone DDS 0.10, which a Pi has, finds no way from the loopback to who announces this machine's
other addresses; its sockets are kept to the loopback device all the same."""

ONE_ADDRESS = (
    "<CycloneDDS><Domain Id='any'><General><Interfaces>"
    "<NetworkInterface address='{}'/></Interfaces></General></Domain></CycloneDDS>"
)


class DomainError(ValueError):
    """No domain of DDS."""


def domain(settings: Ros2Settings, environment: Mapping[str, str]) -> int:
    """The domain to take part in.

    Raises:
        DomainError: ROS_DOMAIN_ID is none.
    """
    if settings.domain_id >= 0:
        return settings.domain_id
    text = environment.get("ROS_DOMAIN_ID", "") or "0"
    if not (text.isascii() and text.isdigit() and int(text) <= MOST_DOMAIN):
        raise DomainError(f"ROS_DOMAIN_ID is {text!r}; valid are 0 to {MOST_DOMAIN}")
    return int(text)


def alone() -> str:
    """The configuration for this machine only, as the library that is installed needs it."""
    with contextlib.suppress(PackageNotFoundError):
        if version("cyclonedds").startswith("0."):
            return ALONE_BEFORE_11
    return ALONE


def reach(host: str, environment: Mapping[str, str]) -> tuple[str | None, bool]:
    """Cyclone DDS's configuration, and whether to keep others out, for what the page listens on."""
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
    """Everything that the process needs to know.

    Args:
        settings: names and domain.
        host: what the page listens on; DDS reaches as far.
        incoming: the commands to hear.
        environment: this program's by default.

    Raises:
        DomainError: ROS_DOMAIN_ID is none.
    """
    environment = os.environ if environment is None else environment
    configuration, confined = reach(host, environment)
    writers = [
        Endpoint(
            settings.full_name(one.name),
            one.type,
            type_hash(one.type),
            one.quality.reliable,
            one.quality.latched,
            one.quality.depth,
        )
        for one in TOPICS
        if one.live
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
