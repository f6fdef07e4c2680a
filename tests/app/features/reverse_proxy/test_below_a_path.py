"""All of the page below a path, in a real Chromium behind JupyterHub's real proxy."""

from __future__ import annotations

import re
from urllib.parse import urlsplit

import pytest
from browsing import PATIENCE_MS, show_all, visit
from playwright.sync_api import expect
from reverse_proxies import needs_proxy, proxied
from serving import started

pytestmark = [pytest.mark.browser, pytest.mark.slow, needs_proxy]
TOKEN = "drive-below-a-path"
PATHS = {"kept": "/user/j%C3%BCrgen/brickpose", "taken away": "/user/ada/brickpose"}


@pytest.fixture(scope="module", params=PATHS)
def address(request, tmp_path_factory):
    """The program's address behind the proxy, which keeps the path or takes it away."""
    folder = tmp_path_factory.mktemp("student")
    words = (
        "learn", "--robot", "kinematic", "--map", "stub", "--port", "0", "--token", TOKEN,
        "--allow-code", "--root-path", f"{PATHS[request.param]}/",
        "--file", str(folder / "my_filter.py"),
    )  # fmt: skip
    with started(*words, says=r"at (http://[^\s/]+)") as (_, own):
        strips = request.param == "taken away"
        with proxied(PATHS[request.param], own, strips=strips) as shown:
            yield f"{shown}/"


@pytest.fixture
def page(browser, address):
    context = show_all(browser.new_context(viewport={"width": 1280, "height": 800}))
    context.set_default_timeout(PATIENCE_MS)
    made = context.new_page()
    wrong: list[str] = []
    made.on("pageerror", lambda error: wrong.append(str(error)))
    made.on("response", lambda answer: _note(answer, address, wrong))
    made.on("websocket", lambda socket: _note_socket(socket.url, address, wrong))
    # Without its last slash, as people type it; a proxy that takes the path away has to add it.
    typed = address if PATHS["taken away"] in address else address.rstrip("/")
    visit(made, f"{typed}?token={TOKEN}")
    yield made
    context.close()
    assert not wrong


def _note(answer, address: str, wrong: list[str]) -> None:
    if answer.url.startswith(("data:", "blob:")):
        return
    if answer.status >= 400 or not f"{answer.url}/".startswith(address.rstrip("/")):
        wrong.append(f"{answer.status} {answer.url}")


def _note_socket(url: str, address: str, wrong: list[str]) -> None:
    if not url.startswith(address.replace("http", "ws", 1)):
        wrong.append(url)


def test_cookies_are_confined_to_the_path(page, address):
    page.locator("#language").select_option("de", force=True)
    page.wait_for_function("document.documentElement.lang === 'de'")
    cookies = {cookie["name"]: cookie["path"] for cookie in page.context.cookies()}
    assert len(cookies) == 3
    assert set(cookies.values()) == {urlsplit(address).path}
    assert "token" not in page.url


def test_the_robot_drives_and_the_camera_shows(page, address):
    before = page.evaluate("window.brickpose.telemetry.odometry")
    page.keyboard.down("w")
    page.wait_for_function(
        "before => Math.hypot(brickpose.telemetry.odometry.x - before.x,"
        " brickpose.telemetry.odometry.y - before.y) > 0.02",
        arg=before,
    )
    page.keyboard.up("w")
    answer = page.request.get(f"{address}camera.jpg")
    assert answer.body()[:2] == b"\xff\xd8"


def test_the_view_in_3d_has_its_scene(page):
    frame = page.frame_locator("iframe")
    expect(frame.locator("canvas").first).to_be_visible()


def test_lens_course_help_and_interface_are_there(page, address):
    page.goto(f"{address}lens")
    expect(page.locator("#board-print")).to_be_visible()
    page.wait_for_function("document.querySelector('#language option')")
    for number in ("", "/2"):
        page.goto(f"{address}learn{number}")
        expect(page.locator("#title")).not_to_be_empty()
        expect(page.locator("#lessons a").first).to_be_visible()
        expect(page.frame_locator("#dashboard").locator("#map-canvas")).to_be_visible()
    page.locator("#lessons a").nth(2).click()
    page.wait_for_url(f"{address}learn/3")
    page.goto(f"{address}help")
    page.wait_for_url(f"{address}help/")
    page.locator("main a[href$='.md']").first.click()
    page.wait_for_url(re.compile(re.escape(address) + r"help/\w+\.md.*"))
    expect(page.locator("h1")).to_be_visible()
    page.goto(f"{address}docs")
    page.locator("a[href='openapi.json']").click()
    page.wait_for_url(f"{address}openapi.json")


def test_a_recording_is_made_and_downloaded(page, tmp_path):
    page.locator("#record").click()
    page.wait_for_function("brickpose.telemetry.recording?.running")
    page.locator("#record").click()
    page.wait_for_function("!brickpose.telemetry.recording?.running")
    with page.expect_download() as download:
        page.locator("#record-file").click()
    file = tmp_path / "drive.mcap"
    download.value.save_as(file)
    assert file.read_bytes().startswith(b"\x89MCAP")
