"""Of what comes faster than it is shown the newest is shown in the end, and nothing twice."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page

pytestmark = [pytest.mark.browser, pytest.mark.slow]

PAINT = """async () => {
  const { DrawLoop } = await import("/static/page/draw_loop.js");
  const painted = [];
  let newest = "first";
  const loop = new DrawLoop();
  const refresh = loop.add(() => painted.push(newest), { hertz: 5 });
  const refreshAnother = loop.add(() => {});
  while (painted.length === 0) await new Promise(requestAnimationFrame);
  newest = "second";
  refresh();
  await new Promise((done) => setTimeout(done, 1000));
  refreshAnother();
  await new Promise((done) => setTimeout(done, 500));
  return painted;
}"""
STREAM = """async () => {
  const { CameraStream } = await import("/static/camera/stream.js");
  const canvas = new OffscreenCanvas(8, 8);
  canvas.getContext("2d");
  const jpeg = await canvas.convertToBlob({ type: "image/jpeg" });
  const picture = (stamp) => {
    const head = new TextEncoder().encode(JSON.stringify({ stamp }));
    return new Blob([new Uint32Array([head.length]), head, jpeg]).arrayBuffer();
  };
  let socket;
  window.WebSocket = class { constructor() { socket = this; } };
  const shown = [];
  const until = async (stamp) => {
    for (let i = 0; i < 100 && !shown.includes(stamp); i++)
      await new Promise((done) => setTimeout(done, 50));
  };
  new CameraStream("camera", ({ stamp }) => shown.push(stamp)).want(true);
  for (const data of await Promise.all([1, 2, 3].map(picture))) socket.onmessage({ data });
  await until(3);
  socket.onmessage({ data: await picture(4) });
  await until(4);
  return shown;
}"""


@pytest.fixture
def page(browser: Browser, server) -> Iterator[Page]:
    """One without the dashboard, which has such parts of its own."""
    made = browser.new_page()
    made.goto(f"{server.url}/static/token.html")
    yield made
    made.close()


def test_a_change_right_after_a_painting_is_painted_once_and_then_it_rests(page: Page) -> None:
    assert page.evaluate(PAINT) == ["first", "second"]


def test_pictures_that_come_while_one_is_decoded_end_with_the_newest(page: Page) -> None:
    assert page.evaluate(STREAM) == [1, 3, 4]
