"""``brickpose single-user``: the dashboard and the lessons, as the single-user server of a hub."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterator
from functools import partial
from urllib.parse import unquote, urlsplit

from fastapi import APIRouter

from app.engine.program import Program
from app.feature import Feature, NewGate, Panel
from app.features.classroom.class_desk import ClassDesk, ClassState
from app.features.classroom.hub_client import HubClient, HubEnvironment
from app.features.classroom.sign_in import Sessions, SignIn
from app.features.classroom.sleep import Sleeper
from app.features.course.learn_command import learn
from app.settings.config import FRONTEND, Config


def serve_user(
    parsed: argparse.Namespace, config_from: Callable[[argparse.Namespace], Config]
) -> int:
    """Serve as the hub's environment says.

    Args:
        parsed: what was typed; the hub's environment wins where it says otherwise.
        config_from: makes settings of it.

    Raises:
        SettingError: no hub has started this.
    """
    hub = HubEnvironment.of(os.environ)
    place = urlsplit(hub.service_url)
    parsed.host, parsed.port = place.hostname or "127.0.0.1", place.port or 8888
    parsed.root_path = hub.prefix
    parsed.no_token = True  # the hub knows who comes
    sleeper = Sleeper()
    desk = Feature(
        name="class",
        about="visitors sign in at the hub, and the teacher's wall has a say",
        gates=(lambda _config: _gates(HubClient(hub), sleeper),),
        routers=(lambda program: _watched(program, sleeper),),
        panels=(Panel("desk", "Class", FRONTEND / "features" / "classroom" / "panel.js"),),
    )
    parsed.features = parsed.features.adding(desk)
    return learn(parsed, config_from(parsed))


def _watched(program: Program, sleeper: Sleeper) -> APIRouter:
    sleeper.watch(program)
    return APIRouter()


def _gates(hub: HubClient, sleeper: Sleeper) -> Iterator[NewGate]:
    own = hub.environment
    # Paths are decoded where they arrive.
    path = unquote(own.prefix)
    yield partial(ClassDesk, owner=own.user, prefix=path, state=ClassState(), sleeper=sleeper)
    yield partial(SignIn, hub=hub, sessions=Sessions())
