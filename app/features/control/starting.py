"""Starts a process that controls a robot: by a fork where that is safe, else anew."""

from __future__ import annotations

import multiprocessing
import os
import sys
import threading
from collections.abc import Sequence
from multiprocessing.connection import Connection
from typing import Any

from app.engine.localization import Localization
from app.engine.plugging import plugged
from app.engine.program import LocalProgram
from app.features.control.process import control
from app.features.control.remote import ControlProcess, RemoteProgram
from app.features.control.settings import ControlSettings
from app.features.control.shared_ring import SharedRing
from app.interruption import uninterrupted
from app.operating_system import children_deaf_to_ctrl_c
from app.settings.config import Config

_shared: list[object] = []


def share_with_forks(program: LocalProgram) -> None:
    """Keep the large parts of a program, so that forks of this process need not be sent them.

    A server that starts with the same field, as those of a class do, has them from here: its own
    copies were 11 MB for each student.
    """
    follower = program.engine.controls.follower
    _shared.extend((program.field, program.field.floor.image))
    if isinstance(follower, Localization):
        entries = follower.models.entries
        _shared.extend((entries, entries.distances, entries.planes))


def build_elsewhere(config: Config, alone: bool) -> RemoteProgram | None:
    """Build a program whose robot another process drives; None if one process is asked for.

    Args:
        config: everything that can be set.
        alone: no other thread was begun in this process yet, also none of a library: then the
            process may be a fork, which has all modules at once and shares their memory. Of
            several threads a fork has one, and what the others had locked stays locked.

    Raises:
        Exception: as ``build_program``.
    """
    if ControlSettings.of(config).one_process:
        return None
    without = plugged().features.left_out

    def start(config: Config) -> ControlProcess:
        return started(config, without)

    forks = alone and sys.platform == "linux" and threading.active_count() == 1
    return RemoteProgram.of(started(config, without, forks=forks), start)


def started(config: Config, without: Sequence[str], *, forks: bool = False) -> ControlProcess:
    """Start a process that controls the robot of a configuration."""
    context: Any = multiprocessing.get_context("fork" if forks else "spawn")
    ours, theirs = context.Pipe()
    ring = SharedRing() if forks else None
    shared = tuple(_shared) if forks else ()
    work = _forked if forks else control
    arguments: tuple[Any, ...] = (theirs, config, without, ring, shared)
    arguments = (ours, *arguments) if forks else arguments
    process = context.Process(target=work, args=arguments, name="control", daemon=True)
    with uninterrupted(), children_deaf_to_ctrl_c():
        process.start()
    theirs.close()  # so that the pipe ends with the process
    return ControlProcess(process, ours, ring, shared)


def _forked(
    servers: Connection,
    connection: Connection,
    config: Config,
    without: Sequence[str],
    ring: SharedRing,
    shared: Sequence[object],
) -> None:
    """Control a robot, in a fork: what the server has open is not for this process."""
    servers.close()
    mine = connection.fileno()
    os.closerange(3, mine)
    os.closerange(mine + 1, os.sysconf("SC_OPEN_MAX"))
    control(connection, config, without, ring, shared)
