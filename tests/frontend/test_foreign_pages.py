"""A page of another origin that shows ours in a frame cannot drive the robot."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
from serving import telemetry, until

pytestmark = [pytest.mark.browser, pytest.mark.slow]

DOORS = ("/", "/static/index.html", "/view/", "/docs", "/api/state", "/camera.mjpg")


class Quiet(SimpleHTTPRequestHandler):
    """Serves a folder and says nothing."""

    def log_message(self, format: str, *args: object) -> None:
        pass


@pytest.fixture(scope="module")
def foreign(tmp_path_factory, server) -> Iterator[str]:
    """Another site: a page for each door, which holds it in a frame."""
    folder: Path = tmp_path_factory.mktemp("site")
    for number, door in enumerate(DOORS):
        frame = f'<iframe src="{server.url}{door}" width="800" height="600"></iframe>'
        (folder / f"{number}.html").write_text(frame)
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=folder)) as site:
        thread = threading.Thread(target=site.serve_forever)
        thread.start()
        yield f"http://127.0.0.1:{site.server_port}"
        site.shutdown()
        thread.join()


@pytest.mark.parametrize("door", DOORS)
def test_clicks_and_keys_on_a_foreign_page_do_not_drive(browser, foreign, live, door) -> None:
    page = browser.new_page()
    try:
        page.goto(f"{foreign}/{DOORS.index(door)}.html", wait_until="load")
        # What it shows instead of ours is the browser's own page of an error, or nothing.
        shown = [frame.url for frame in page.frames if frame.parent_frame is not None]
        assert all(url in ("", "about:blank", "chrome-error://chromewebdata/") for url in shown)
        page.mouse.click(400, 300)
        page.keyboard.down("w")
        end = telemetry(live)["stamp"] + 0.7
        until(live, lambda now: now["stamp"] > end)
        now = telemetry(live)
        page.keyboard.up("w")
    finally:
        page.close()
    assert (now["mode"], now["twist"]["v"]) == ("idle", 0)
