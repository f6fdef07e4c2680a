"""A server that has died is begun again once, however many ask for it."""

from __future__ import annotations

import asyncio
import os
from unittest.mock import MagicMock

import pytest
from classes import needs_hub

pytestmark = needs_hub
GONE = 4_194_303
"""A number that the system gives to no process."""


@pytest.fixture
def spawner(tmp_path):
    from app.features.classroom.hub.spawner import StudentSpawner

    made = StudentSpawner(class_folder=str(tmp_path))
    made.orm_spawner = MagicMock(server=None)
    made.user = MagicMock()
    made.db = MagicMock()
    return made


def test_two_who_ask_at_once_begin_one_server(spawner, monkeypatch):
    from app.features.classroom.hub.spawner import _started_at

    begun = []

    async def copy(*, died: bool = False) -> None:
        await asyncio.sleep(0.01)
        begun.append(died)
        spawner.pid, spawner.started_at = os.getpid(), _started_at(os.getpid())

    spawner.pid, spawner.started_at, spawner.request = GONE, 1.0, {"words": []}
    monkeypatch.setattr(spawner, "_copy", copy)

    async def both() -> list[int | None]:
        return await asyncio.gather(spawner.poll(), spawner.poll())

    assert asyncio.run(both()) == [None, None]
    assert begun == [True], "the new server is told that the one before had died"
