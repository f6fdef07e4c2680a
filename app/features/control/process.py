"""The process that controls the robot: it builds the program, steps it, and sends its snapshots."""

from __future__ import annotations

import os
import pickle
import signal
import sys
import threading
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from multiprocessing.connection import Connection
from queue import SimpleQueue
from typing import Any

import cv2

from app.engine.added_models import ModelChoice
from app.engine.build import build_on_field, build_on_map, build_program
from app.engine.engine_thread import HAND_OVER_S
from app.engine.plugging import plug_in
from app.engine.problems import LOG, ProblemState
from app.engine.program import LocalProgram
from app.engine.robot_facts import RobotFacts, close_robot
from app.engine.snapshot import DrawnMap
from app.feature_search import find_features
from app.features.control.messages import (
    Begun,
    Ended,
    Follow,
    Go,
    PutMap,
    Refused,
    SentTick,
    Stop,
    Watched,
)
from app.features.control.parts import PartsWriter
from app.features.control.shared_ring import SharedRing
from app.features.control.tick_sender import TickSender
from app.operating_system import set_niceness
from app.settings.config import Config
from robot.description.spec import RobotSpec
from robot.fields.field import Field
from robot.interface import Frame
from robot.localization.estimate import Estimate
from robot.localization.filter import Cloud
from robot.localization.models.entry_field import EntryField
from robot.localization.parameters import LocalizationParameters
from robot.localization.weighing import Weighing
from robot.scan import Scan
from robot.scanning.line_scanner import LineScan, LineScanner
from sim.real_time import RealTime
from sim.simulated import SimSettings

NICENESS = -5
"""Control comes before the server and other programs, where the system allows it."""

PARTS = (
    Cloud,
    DrawnMap,
    EntryField,
    Estimate,
    Field,
    Frame,
    LineScan,
    LineScanner,
    LocalizationParameters,
    ModelChoice,
    ProblemState,
    RobotSpec,
    Scan,
    SimSettings,
    Weighing,
)
"""Classes of what many snapshots share."""

PATIENCE_S = 2.0
"""A loop that hangs is ended after this time, once the server has gone [s]."""


def control(
    connection: Connection,
    config: Config,
    without: Sequence[str],
    ring: SharedRing | None = None,
    shared: Sequence[object] = (),
) -> None:
    """Control a robot until the server has gone or asks for the end; the work of the process.

    Args:
        connection: to the server.
        config: everything that can be set.
        without: the names of features that are left out.
        ring: memory that the server shares; without it, pictures go through the pipe.
        shared: parts of snapshots that the server has, too, because this process is its fork.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the server, which then asks
    sys.setswitchinterval(HAND_OVER_S)
    set_niceness(NICENESS)
    cv2.setNumThreads(1)
    if ring is None:  # a fork has what its server has plugged in
        plug_in(find_features(without))
    _ControlProcess(connection, ring, shared).work(config)


class _ControlProcess:
    def __init__(
        self, connection: Connection, ring: SharedRing | None, shared: Sequence[object]
    ) -> None:
        self._connection = connection
        self._parts = PartsWriter(PARTS, ring, shared)
        self._sending = threading.Lock()
        self._stop = threading.Event()
        """Set when the loop at hand shall end."""
        self._gone = threading.Event()
        """Set when the server has gone."""
        self._orders: SimpleQueue[Go | Follow | None] = SimpleQueue()
        """What the main thread waits for between two loops; None: the server has gone."""
        self._watched = Watched(rate=0.0, every=False)
        self._sender: TickSender | None = None
        self._program: LocalProgram | None = None
        self._main = threading.get_ident()
        with suppress(ValueError):  # not in the main thread, as in a test
            signal.signal(signal.SIGTERM, lambda number, frame: self._stop.set())

    def work(self, config: Config) -> None:
        threading.Thread(target=self._listen, name="orders", daemon=True).start()
        following = self._built(lambda: build_program(config, RealTime()))
        while following is not None:
            following = self._run(following)

    def _built(self, build: Any) -> LocalProgram | None:
        """Build a program and tell the server, or tell it why not."""
        try:
            program: LocalProgram = build()
        except Exception as error:
            self._send(Refused(error))
            return None
        scanner = program.engine.scanner
        begun = Begun(
            RobotFacts.of(program.robot),
            program.field,
            program.config,
            program.given,
            scanner,
        )
        self._send(begun)
        return program

    def _run(self, program: LocalProgram) -> LocalProgram | None:
        """Run one program's loop; return the next one's, or None at the end."""
        engine = program.engine
        self._stop.clear()
        self._program = program
        if not isinstance(self._orders.get(), Go):
            close_robot(program.robot)
            return None
        sender = TickSender(engine, self._main, lambda: self._watched, self._send)
        self._sender = sender
        if self._gone.is_set():
            self._stop.set()
        engine.run(self._stop)
        sender.finish(PATIENCE_S)
        self._send(Ended(engine.failure))
        if not engine.handed_over or engine.failure is not None:
            return None
        order = self._orders.get()
        if not isinstance(order, Follow):
            close_robot(program.robot)
            return None
        if order.place is None:
            return self._built(lambda: build_on_field(program, order.name, order.field, RealTime()))
        place = order.place
        return self._built(lambda: build_on_map(program, order.name, order.field, place))

    def _listen(self) -> None:
        """Take orders until the server has gone; then the robot stops, and the process ends."""
        while True:
            try:
                order = pickle.loads(self._connection.recv_bytes())
            except (OSError, EOFError):
                break
            self._take(order)
        self._gone.set()
        self._stop.set()
        self._orders.put(None)
        time.sleep(PATIENCE_S)
        os._exit(1)  # the main thread hangs in a user's model, or it would have ended by now

    def _take(self, order: Any) -> None:
        program = self._program
        if isinstance(order, Go | Follow):
            self._orders.put(order)
        elif isinstance(order, Watched):
            self._watched = order
            if self._sender is not None:
                self._sender.look()
        elif isinstance(order, Stop):
            if program is not None:
                program.engine.handed_over = order.hand_over
            self._stop.set()
        elif program is None:
            LOG.warning("an order came before there was a program: %r", order)
        elif isinstance(order, PutMap):
            program.engine.drawn.put(order.map)
        else:
            program.engine.commands.put(order)

    def _send(self, message: object) -> None:
        with suppress(OSError), self._sending:
            try:
                written = self._parts.write(message)
            except Exception as error:
                written = self._parts.write(_without_strange_parts(message, error))
            self._connection.send_bytes(written)


def _without_strange_parts(message: object, error: Exception) -> object:
    """Return a message without what others have put into it, which cannot be sent."""
    if isinstance(message, Refused):
        return Refused(RuntimeError(repr(message.error)))
    if isinstance(message, SentTick):
        LOG.warning("what features show of a tick cannot be sent: %s", error)
        return replace(message, snapshot=replace(message.snapshot, added={}))
    raise error
