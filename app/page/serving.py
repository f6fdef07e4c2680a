"""Runs the web application on a socket until it is stopped."""

from __future__ import annotations

import asyncio
import socket
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial

import uvicorn
from anyio import from_thread

from app.console import say
from app.engine.build import build_on_field, build_on_map, build_program
from app.engine.engine_thread import HAND_OVER_S, EngineThread
from app.engine.plugging import plugged
from app.engine.program import LocalProgram, Program
from app.engine.robot_facts import close_robot
from app.interruption import Interrupted, deferred
from app.page.access_options import Front
from app.page.listening import Listening, listen
from app.page.outlets import Outlets
from app.page.server import create_app
from app.page.tokens import Tokens
from app.page.web_server import LeavesSignals, settings_of
from app.settings.config import Config
from robot.errors import CommandError
from robot.fields.field import Field
from robot.localization.estimate import Hypothesis
from sim.real_time import RealTime

ANSWERED_S = 0.3
"""A command is answered within this time [s]."""


class Server:
    """The web application of one program, with the engine's thread."""

    def __init__(
        self, program: Program, tokens: Tokens | None = None, front: Front = Front()
    ) -> None:
        """Prepare to serve; requests need one of the tokens, if there are any."""
        features = plugged().features
        self.successor: Callable[[], Program] | None = None
        """Builds the next program; None ends the server."""
        routers, failures = features.routers(program)
        program = replace(program, complaints=(*features.failures, *failures))
        self._program = program
        self._engine = program.engine
        self._thread = EngineThread(program.engine, program.loop)
        change_map = None if program.loop else self._change_map
        self._outlets = Outlets(program, change_map, self._go_on)
        app = create_app(program, self._thread, self._outlets, tokens, routers)
        self._uvicorn = _StopsTheRobotFirst(settings_of(app, front), self._thread)

    def run(self, listening: Listening) -> None:
        """Serve until stopped."""
        sys.setswitchinterval(HAND_OVER_S)
        self._outlets.start()
        try:
            self._uvicorn.serve_on(listening)
        finally:
            self._thread.stopping.set()
            self._outlets.close()

    def _change_map(self, name: str, field: Field, place: Hypothesis | None) -> None:
        """Switch to another map soon; called in a worker thread of the event loop."""
        following = partial(_successor, self._program, name, field, place)
        from_thread.run_sync(partial(self._end_soon, following, hand_over=True))

    def _go_on(self, following: Callable[[], Program]) -> None:
        """Switch to another program soon; called in a worker thread of the event loop."""
        from_thread.run_sync(partial(self._end_soon, following, hand_over=False))

    def _end_soon(self, following: Callable[[], Program], *, hand_over: bool) -> None:
        """End this program soon; called in the event loop, so that only one of two clients wins.

        Raises:
            CommandError: it is already ending; a second program could take the robot, and
                nobody would close it.
        """
        if self.successor is not None:
            raise CommandError("the program is already switching; wait a second")
        self.successor = following
        self._engine.handed_over = hand_over
        # The page's command must be answered first.
        asyncio.get_running_loop().call_later(ANSWERED_S, self.stop)

    @property
    def stopped(self) -> bool:
        """Whether a stop holds."""
        return self._outlets.drivers.state.stopped

    @property
    def handed_on(self) -> Mapping[str, object]:
        """What features have to know of this program in the next one, by their names."""
        return self._outlets.handed_on()

    def stop(self) -> None:
        """Ask the server to end, from any thread or from a signal handler.

        It takes no lock: a second signal would wait forever for a lock that the first one holds.
        """
        self._uvicorn.should_exit = True


def build_served(config: Config, *, alone: bool = False) -> Program:
    """Build a program to serve, with its robot in this process unless a feature has it elsewhere.

    A real robot is active from here on, so the caller must close it.

    Args:
        config: everything that can be set.
        alone: whether no other thread was begun in this process yet, also none of a library.

    Raises:
        Exception: as ``build_program``.
    """
    for build in plugged().builders:
        program = build(config, alone)
        if program is not None:
            return program
    return build_program(config, RealTime())


def serve(
    program: Program,
    listening: Listening,
    tokens: Tokens | None = None,
    front: Front = Front(),
    announce: Callable[[], object] = lambda: None,
) -> Program | None:
    """Serve until SIGINT or SIGTERM; then stop the motors first, and disconnect viewers next.

    Returns the next program if the page changes the map or opens a recording; else None.

    Args:
        program: the program to serve.
        listening: the listening socket.
        tokens: requests need one of them, if there are any.
        front: what stands before it.
        announce: prints the address; from then on, a signal is the usual end of the program.
    """
    following: Program | None = None
    try:
        server = Server(program, tokens, front)
        with suppress(Interrupted), deferred(server.stop) as asked:
            announce()
            server.run(listening)
            if server.successor is not None and not asked():
                following = replace(
                    server.successor(), stopped=server.stopped, handed_on=server.handed_on
                )
    finally:
        if following is None:
            # The engine has closed the robot already, unless it never started or handed it over.
            close_robot(program.robot)
    return following


def _successor(program: Program, name: str, field: Field, place: Hypothesis | None) -> Program:
    if not isinstance(program, LocalProgram):
        return program.on_field(name, field, place)
    if place is None:
        return build_on_field(program, name, field, RealTime())
    return build_on_map(program, name, field, place)


def serve_on(
    program: Program, port: int, tokens: Tokens | None = None, front: Front = Front()
) -> None:
    """Serve one program after the other at the same address, as the page asks for them."""
    following: Program | None = program
    while following is not None:
        with listen(following.config.host, port) as listening:
            words = f"It goes on with {following.robot.name}, on {following.field.name}"
            ready = partial(say, words)
            following = serve(following, listening, tokens, front, ready)


class _StopsTheRobotFirst(LeavesSignals):
    def __init__(self, config: uvicorn.Config, thread: EngineThread) -> None:
        super().__init__(config)
        self._thread = thread

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        self._thread.stopping.set()
        await super().shutdown(sockets)
