"""What a link does before it leads on: at a robot that is being ended, and at one in use."""

from __future__ import annotations

import asyncio
from datetime import UTC, datetime
from types import SimpleNamespace
from unittest.mock import MagicMock

import pytest
from classes import needs_hub

pytestmark = needs_hub


def test_a_link_waits_until_an_idle_robot_has_ended_but_not_for_ever():
    from app.features.classroom.hub.authenticator import until_ended

    async def run() -> None:
        spawner = SimpleNamespace(pending="stop")
        waiting = asyncio.ensure_future(until_ended(spawner))
        await asyncio.sleep(0.1)
        assert not waiting.done()
        spawner.pending = None
        await asyncio.wait_for(waiting, 5.0)
        await asyncio.wait_for(until_ended(SimpleNamespace(pending="spawn")), 5.0)
        await asyncio.wait_for(until_ended(SimpleNamespace(pending="stop"), 0.1), 5.0)

    asyncio.run(run())


@pytest.mark.parametrize("active", [True, False])
def test_a_link_notes_the_use_of_a_robot_that_runs(active):
    from app.features.classroom.hub.authenticator import note_use

    kept: list[bool] = []
    spawner = SimpleNamespace(active=active, orm_spawner=SimpleNamespace(last_activity=None))
    note_use(spawner, SimpleNamespace(commit=lambda: kept.append(True)))
    noted = spawner.orm_spawner.last_activity
    assert bool(kept) == active
    assert (noted is not None) == active
    if active:  # in UTC, as the hub has it
        assert abs((datetime.now(UTC).replace(tzinfo=None) - noted).total_seconds()) < 5


@pytest.mark.parametrize(("notebook", "page"), [(False, "/learn/1"), (True, "/lab")])
def test_a_link_opens_a_page_that_its_server_has(notebook, page, tmp_path):
    from jupyterhub.spawner import Spawner
    from traitlets.config import Config

    from app.features.classroom.hub.authenticator import first_page
    from app.features.classroom.hub.configuration import configure

    c = Config()
    configure(c, str(tmp_path), host="127.0.0.1", port=8000, memory_mb=700, disk_mb=50,
              idle_s=60, notebook=notebook)  # fmt: skip
    spawner = Spawner(config=c, orm_spawner=MagicMock(server=None), hub=MagicMock())
    assert first_page(spawner) == page
