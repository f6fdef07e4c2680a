"""Serves below a hub: ``brickpose single-user``, one student's robot and lessons, as its
single-user server; ``brickpose shared-robot``, the class's robot, as its service.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from urllib.parse import unquote, urlsplit

from fastapi import APIRouter

from app.engine.program import Program
from app.feature import Feature, NewGate, Panel
from app.features.classroom.class_desk import ClassDesk, ClassState
from app.features.classroom.hub_client import SHARED_ROBOT, HubClient, HubEnvironment
from app.features.classroom.shared.queue_desk import QueueDesk
from app.features.classroom.shared.turns import TurnQueue
from app.features.classroom.sign_in import Sessions, SignIn
from app.features.classroom.sleep import Sleeper
from app.features.classroom.told_sockets import ToldSockets
from app.features.classroom.warm.request import ENDED
from app.features.course.learn_command import learn
from app.languages.marking import phrase
from app.operating_system import set_niceness
from app.page.run_command import run_dashboard
from app.settings.config import FRONTEND, Config

SERVING_NICENESS = 8
"""Place of a student's server in the queue for the processor, as ``nice`` counts: behind its own
process that drives, which is not allowed to come first. So pictures get fewer when a class has more
work than the computer can do, and the robots drive as before. Half or twice of it changes what
control gets while both wait, by the kernel's table: 1.5 or 22 times as much, of 3.8 as it is."""
PANELS = FRONTEND / "features" / "classroom"
SHARED_PANEL = Panel("queue", phrase("Queue"), PANELS / "queue_panel.js")


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
    hub = _as_the_hub_says(parsed)
    sleeper, client, sessions = Sleeper(), HubClient(hub), Sessions()
    # What the teacher ordered, and who is signed in, outlast a change of the field.
    state = ClassState(ended=os.environ.get(ENDED, ""))

    def gates(_config: Config) -> Iterator[NewGate]:
        state.sockets = ToldSockets()  # those of the program before are closed
        # Paths are decoded where they arrive.
        own, path = hub.user, unquote(hub.prefix)
        yield partial(ClassDesk, owner=own, prefix=path, state=state, sleeper=sleeper)
        yield partial(SignIn, hub=client, sessions=sessions)

    desk = Feature(
        name="class",
        about="visitors sign in at the hub, and the teacher's wall has a say",
        gates=(gates,),
        routers=(lambda program: _watched(program, sleeper),),
        panels=_student_panels(),
    )
    parsed.features = parsed.features.adding(desk)
    return learn(parsed, config_from(parsed))


def serve_shared(
    parsed: argparse.Namespace, config_from: Callable[[argparse.Namespace], Config]
) -> int:
    """Serve a robot to a class, one driver after the other; else as ``serve_user``."""
    hub = _as_the_hub_says(parsed)
    client, turns, sessions = HubClient(hub), TurnQueue(parsed.turn * 60), Sessions()

    def gates(_config: Config) -> Iterator[NewGate]:
        yield partial(QueueDesk, prefix=unquote(hub.prefix), turns=turns)
        yield partial(SignIn, hub=client, sessions=sessions)

    desk = Feature(
        name="class",
        about="visitors sign in at the hub, and drive one after the other",
        gates=(gates,),
        panels=(SHARED_PANEL,),
    )
    return run_dashboard(parsed, config_from(parsed), parsed.features.adding(desk), "/")


def _as_the_hub_says(parsed: argparse.Namespace) -> HubEnvironment:
    hub = HubEnvironment.of(os.environ)
    place = urlsplit(hub.service_url)
    parsed.host, parsed.port = place.hostname or "127.0.0.1", place.port or 8888
    parsed.root_path = hub.prefix
    parsed.no_token = True  # the hub knows who comes
    return hub


def _student_panels() -> tuple[Panel, ...]:
    desk = Panel("desk", phrase("Class"), PANELS / "panel.js")
    return (desk, SHARED_PANEL) if os.environ.get(SHARED_ROBOT) else (desk,)


def _watched(program: Program, sleeper: Sleeper) -> APIRouter:
    sleeper.watch(program)
    with suppress(OSError):  # without root nobody comes forward again
        set_niceness(SERVING_NICENESS)  # its process that drives was begun before
    return APIRouter()
