"""Makes the pictures of the page in the documents: ``page_pictures.py FOLDER [NAME ...]``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import cv2
from browsing import SOFTWARE_GL, opened
from playwright.sync_api import Page, sync_playwright
from serving import ServedProgram, ask, serving, until

from benchmarks.programs import CHROMIUM

DROVE_S = 14.0
"""So long a figure-eight is driven before the pictures are taken [s]."""
SEEN_MS = 10_000
"""After so long a view in 3D stands, drawn by software [ms]."""
WIDE, LAPTOP, PHONE = (1600, 1000), (1280, 720), (390, 844)
LIGHT: dict[str, Any] = {}
TOUCH = {"has_touch": True}
PICTURES = {
    "wide": (WIDE, "drive", LIGHT),
    "laptop": (LAPTOP, "drive", LIGHT),
    "understand": (WIDE, "understand", LIGHT),
    "understand_laptop": (LAPTOP, "understand", LIGHT),
    "present": (WIDE, "present", LIGHT),
    "present_laptop": (LAPTOP, "present", LIGHT),
    "camera": (LAPTOP, "simple", LIGHT),
    "help": (LAPTOP, "simple", LIGHT),
    "ask": (LAPTOP, "simple", LIGHT),
    "likelihood": (LAPTOP, "simple", LIGHT),
    "dark": (WIDE, "drive", {"color_scheme": "dark"}),
    "forced": (WIDE, "drive", {"forced_colors": "active"}),
    "phone": (PHONE, None, TOUCH),
}
"""Size of the window, ready layout, and what the browser asks for."""
ASIDE_M = (0.032, -0.01)
"""So far from the estimate a pose is asked what it expects, in x and y [m]."""


def main(folder: str, *names: str) -> int:
    wanted = {name: PICTURES[name] for name in names or PICTURES}
    with (
        serving("--robot", "sim", "--map", "stub", "--seed", "3") as server,
        sync_playwright() as playwright,
    ):
        browser = playwright.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", *SOFTWARE_GL]
        )
        for look in (LIGHT, *(look for _, _, look in wanted.values() if look)):
            same = {name: row for name, row in wanted.items() if row[2] == look}
            width, height = PHONE if look is TOUCH else WIDE
            size = {"width": width, "height": height}
            if same:
                for page in opened(browser, server, **size, view=True, first_visit=True, **look):
                    drive(server)
                    for name, ((across, up), layout, _) in same.items():
                        page.set_viewport_size({"width": across, "height": up})
                        arrange(page, name, layout)
                        save(page, name, Path(folder) / f"{name}.png")
        browser.close()
    return 0


def drive(server: ServedProgram) -> None:
    """Drive a part of the figure-eight from the start, while the page looks."""
    with server.live() as live:
        ask(live, type="take")  # a stop that ended the drive before holds
        ask(live, type="place", x=0.0, y=0.0, theta=0.0)
        ask(live, type="set_pose", x=0.0, y=0.0, theta=0.0)
        ask(live, type="figure_eight", start=True)
        begun = now = until(live, lambda now: now["mode"] == "figure_eight")["stamp"]
        while now < begun + DROVE_S:
            ask(live, type="figure_eight")
            now = until(live, lambda _: True)["stamp"]
        ask(live, type="stop")


def arrange(page: Page, name: str, layout: str | None) -> None:
    """Bring the page to what its picture shows."""
    if layout is None:
        page.get_by_role("tab", name="Map").click()
    else:
        page.locator("#layout-open").click()
        page.locator(f"[data-layout={layout}]").click()
        page.keyboard.press("Escape")
    if name == "help":
        page.locator("#help-open").click()
    if name in ("ask", "likelihood"):
        asked(page, shaded=name == "likelihood")
    if name == "camera":
        page.locator("[data-more-of=camera]").click()
        page.locator("#camera-profile").click()
    # No button is drawn as the one that was pressed last.
    page.evaluate("document.activeElement.blur()")
    page.mouse.move(1, 1)
    page.wait_for_timeout(SEEN_MS if layout in ("drive", "understand") else SEEN_MS / 10)


def asked(page: Page, *, shaded: bool) -> None:
    """Ask a pose beside the estimate, and one of its rays; shade the field if that is wanted."""
    tool, box = page.locator("button[data-tool=ask]"), page.locator("#particles")
    if tool.get_attribute("aria-pressed") != "true":
        tool.click()
    estimate = page.evaluate("window.brickpose.telemetry.estimate")
    box.get_by_role("button", name="nearest to estimate").click()
    box.get_by_role("application").wait_for()
    for place, (axis, aside) in enumerate(zip("xy", ASIDE_M, strict=True)):
        field = box.get_by_role("textbox").nth(place)
        field.fill(f"{1000 * (estimate[axis] + aside):.0f}")
        field.press("Enter")
    box.get_by_role("application").click()
    if shaded:
        box.get_by_role("button", name="show").click()


def save(page: Page, name: str, path: Path) -> None:
    parts = {"camera": "#camera", "ask": "#map", "likelihood": "#map"}
    (page.locator(parts[name]) if name in parts else page).screenshot(path=path)
    picture = cv2.imread(str(path))
    assert picture is not None
    # What a browser writes is packed for speed.
    cv2.imwrite(str(path), picture, (cv2.IMWRITE_PNG_COMPRESSION, 9))
    print(path)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
