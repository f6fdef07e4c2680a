"""A page whose thread is busy for long keeps its connections: no reload, nothing refused."""

import pytest
from browsing import opened

pytestmark = pytest.mark.slow

BUSY_S = 14
"""Longer than the interval of pings, and again as long."""


@pytest.fixture
def page(browser, server):
    yield from opened(browser, server, width=1024, height=768, view=False)


def test_a_busy_page_keeps_its_connections(page) -> None:
    page.wait_for_function("window.brickpose.delays.length > 0")
    again: list[str] = []
    page.on("websocket", lambda socket: again.append(socket.url))
    stamp = page.evaluate(
        """(busy) => {
            const end = performance.now() + 1000 * busy;
            while (performance.now() < end);
            return window.brickpose.telemetry.stamp;
        }""",
        BUSY_S,
    )
    # What was sent meanwhile comes first; a connection that was closed would be opened anew.
    page.wait_for_function(
        "(then) => window.brickpose.telemetry.stamp > then", arg=stamp + BUSY_S + 1
    )
    assert again == []
