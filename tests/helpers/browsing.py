"""The page, opened in a real Chromium."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, BrowserContext, Page, WebSocketRoute, expect
from serving import ServedProgram, ask, until

LOOKS = {
    "light": {"color_scheme": "light"},
    "dark": {"color_scheme": "dark"},
    "forced colours": {"forced_colors": "active"},
}
"""How a page may look, as options of a browser's context."""

# Without a graphics card a page is quickest when nothing pretends that there is one.
NO_GL = ["--disable-gpu"]
PATIENCE_MS = 60_000
"""A page on a busy machine comes late, which is no fault of it."""

expect.set_options(timeout=PATIENCE_MS)

SOFTWARE_GL = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


ALL_SHOWN = """() => {
  const row = (shares, ...parts) => ({ split: "row", shares, parts });
  const column = (shares, ...parts) => ({ split: "column", shares, parts });
  const tree = row([56, 44], column([68, 32], "map", row([42, 58], "drive", "filter")),
                   column([57, 43], "camera", row([50, 50], "view", "plots")));
  if (innerWidth >= 1000) {
    localStorage["brickpose.layout"] ??= JSON.stringify({ kind: "brickpose-layout-1", tree });
  }
  localStorage["brickpose.more"] ??= "bar map camera view";
}"""
"""Makes a browser one that has asked for more than a first visit shows."""


KEEP_WHAT_IS_TOLD = """() => {
  window.told = [];
  const send = WebSocket.prototype.send;
  WebSocket.prototype.send = function (text) {
    window.told.push(String(text));
    send.call(this, text);
  };
}"""
"""Makes a page keep what it tells the robot, in ``window.told``."""

LETS_GO = """() => {
  const drives = window.told.map((text) => JSON.parse(text)).filter(({ type }) => type === "drive");
  return drives.at(-1)?.v === 0 && drives.at(-1)?.omega === 0;
}"""


def show_all(context: BrowserContext) -> BrowserContext:
    """Let the pages of a browser show all panels and tools, as tests need that press them."""
    context.add_init_script(f"try {{ ({ALL_SHOWN})() }} catch {{}}")
    return context


def keep_what_is_told(context: BrowserContext) -> BrowserContext:
    """Let the pages of a browser keep what they tell the robot, for ``let_go``."""
    context.add_init_script(f"({KEEP_WHAT_IS_TOLD})()")
    return context


def let_go(page: Page) -> None:
    """Wait until a page's last word on driving is that the robot stand.

    To see the robot stand is not enough: it also does when a page that drives on is late to say so.
    """
    page.wait_for_function(LETS_GO)


def visit(page: Page, address: str) -> None:
    """Open the dashboard, and wait until it is there: a press before that does nothing."""
    page.goto(address)
    page.wait_for_function("window.brickpose?.connected && window.brickpose?.telemetry")


def opened(
    browser: Browser,
    server: ServedProgram,
    *,
    width: int,
    height: int,
    view: bool,
    first_visit: bool = False,
    **options,
) -> Iterator[Page]:
    """A page that shows all; with ``first_visit`` one that shows what it does at first."""
    size = {"width": width, "height": height}
    context = keep_what_is_told(browser.new_context(viewport=size, **options))
    if not first_visit:
        show_all(context)
    context.set_default_timeout(PATIENCE_MS)
    complaints: list[str] = []
    made = context.new_page()
    made.on("pageerror", lambda error: complaints.append(str(error)))
    asked: list[str] = []
    made.on("request", lambda request: asked.append(request.url))
    if not view:
        made.route("**/view/**", lambda route: route.fulfill(body="<p>no 3D here</p>"))
    made.goto(server.url)
    made.wait_for_function("window.brickpose?.connected && window.brickpose?.telemetry?.estimate")
    yield made
    context.close()
    assert not complaints, complaints
    elsewhere = [url for url in asked if server.address not in url and not url.startswith("data:")]
    assert not [url for url in elsewhere if not url.startswith("blob:")], "fetched from elsewhere"
    with server.live() as after:
        ask(after, type="stop")
        until(after, lambda now: now["mode"] == "idle")


DROP = """([names, texts]) => {
  const files = new DataTransfer();
  names.forEach((name, i) => files.items.add(
    new File([typeof texts[i] === "string" ? texts[i] : Uint8Array.from(texts[i])], name)));
  for (const type of ["dragover", "drop"])
    window.dispatchEvent(new DragEvent(type, { dataTransfer: files, cancelable: true }));
}"""


def drop(page: Page, **files: str | bytes) -> None:
    """Drop files on the page, by names in which a dot is written as two underscores."""
    contents = [each if isinstance(each, str) else list(each) for each in files.values()]
    page.evaluate(DROP, [[name.replace("__", ".") for name in files], contents])


def drop_as_a_hand_does(page: Page, *paths: Path, over: str = "body") -> None:
    """Drag files of the disk over a part of the page, and let them go there."""
    box = page.locator(over).bounding_box()
    assert box is not None, over
    at = {"x": box["x"] + box["width"] / 2, "y": box["y"] + box["height"] / 2}
    data = {"items": [], "files": [str(path) for path in paths], "dragOperationsMask": 1}
    session = page.context.new_cdp_session(page)
    for kind in ("dragEnter", "dragOver", "drop"):
        session.send("Input.dispatchDragEvent", {"type": kind, **at, "data": data})
    session.detach()


def change_telemetry(socket: WebSocketRoute, change: Callable[[dict[str, Any]], object]) -> None:
    """Be between page and program, and change each message of telemetry on its way."""
    program = socket.connect_to_server()
    socket.on_message(program.send)

    def pass_on(text: str | bytes) -> None:
        message = json.loads(text)
        if message["type"] == "telemetry":
            change(message)
        socket.send(json.dumps(message))

    program.on_message(pass_on)
