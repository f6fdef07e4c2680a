"""Fields are chosen by their pictures, and files that are dropped become fields, on the page."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from axe import needs_axe, violations
from browsing import PATIENCE_MS, drop, opened, show_all, visit
from playwright.sync_api import Page, expect
from serving import serving, started

pytestmark = [pytest.mark.browser, pytest.mark.slow]

SVG = 'xmlns="http://www.w3.org/2000/svg"'
RING = (
    f'<svg {SVG} width="900mm" height="900mm" viewBox="-450 -450 900 900"><circle r="300" '
    'fill="none" stroke="black" stroke-width="50"/></svg>'
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("fields")


@pytest.fixture(scope="module")
def server(folder):
    config = folder.parent / "field_pictures.toml"
    config.write_text(f'[mapping]\nfolder = "{folder}"\n[recording]\nfolder = "{folder}/r"\n')
    with serving("--map", "square", "--robot", "kinematic", "--config", str(config)) as running:
        yield running


@pytest.fixture
def page(browser, server) -> Iterator[Page]:
    yield from opened(browser, server, width=1100, height=760, view=False)


def on_field(page: Page, name: str) -> None:
    expect(page.locator("#stat-field")).to_have_text(name)
    page.wait_for_function("window.brickpose?.connected && window.brickpose?.telemetry?.estimate")


@needs_axe
def test_a_field_is_chosen_by_its_picture(page: Page) -> None:
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.reload()
    page.wait_for_function("window.brickpose?.connected && window.brickpose?.telemetry?.estimate")
    assert not [url for url in asked if "drawings" in url or "gallery" in url], "drawn at the start"
    page.locator("#field-open").click()
    pictures = page.locator("#field-pictures img")
    expect(page.locator("#field-pictures [data-name=town]")).to_be_visible()
    for name in ("square", "town", "generated-17"):
        picture = page.locator(f"#field-pictures [data-name={name}] img")
        picture.scroll_into_view_if_needed()
        page.wait_for_function("(one) => one.naturalWidth > 0", arg=picture.element_handle())
    assert pictures.count() >= 6
    pressed = page.locator("#field-pictures [aria-pressed=true]")
    expect(pressed).to_have_attribute("data-name", "square")
    assert violations(page, "#field") == []
    page.evaluate("""() => {
        window.said = [];
        const banner = document.querySelector("#banner");
        const note = () => window.said.push(banner.textContent);
        const all = { childList: true, characterData: true, subtree: true };
        new MutationObserver(note).observe(banner, all);
    }""")
    page.locator("#field-pictures [data-name=stub]").click()
    on_field(page, "stub")
    expect(pressed).to_have_attribute("data-name", "stub")
    # It was asked for: no loss that frightens a class.
    said = " ".join(page.evaluate("window.said"))
    assert "Loading: the page connects again" in said
    assert "The connection is lost" not in said


def test_a_dropped_drawing_is_kept_and_the_robot_is_on_it(page: Page, folder: Path) -> None:
    drop(page, **{"Mein Kreis__svg": RING})
    on_field(page, "Mein-Kreis")
    assert (folder / "Mein-Kreis.svg").read_text() == RING
    drop(page, **{"Mein Kreis__svg": RING})
    on_field(page, "Mein-Kreis-2")
    page.locator("#figure-eight").click()
    words = "The figure-eight would leave this field by \\d+ mm, and from the start, too"
    expect(page.locator("#toasts")).to_contain_text(re.compile(words))
    opener = page.locator("#field-open")
    opener.click()
    remove = page.get_by_role("button", name="Delete Mein-Kreis-2")
    kept = remove.element_handle()
    # What is read again on opening takes no half-done press away.
    (folder / "later.svg").write_text(RING)
    opener.click()
    opener.click()
    expect(page.locator("#field-pictures [data-name=later]")).to_be_visible()
    assert kept is not None and kept.evaluate("(one) => one.isConnected")
    # At once: a busy machine takes longer for two presses than the question is open.
    remove.evaluate("(button) => { button.click(); button.click(); }")
    expect(remove).to_have_count(0)
    assert not (folder / "Mein-Kreis-2.svg").exists()


def test_a_ros_map_is_its_yaml_with_its_picture(page: Page, folder: Path) -> None:
    cells = np.full((60, 80), 254, np.uint8)
    cells[:3], cells[-3:], cells[:, :3], cells[:, -3:] = 0, 0, 0, 0
    cells[20:30, 20:30] = 0
    picture = cv2.imencode(".pgm", cells)[1].tobytes()
    text = (
        "image: /somewhere/else/office.pgm\nresolution: 0.05\norigin: [-2, -1.5, 0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.25\n"
    )
    told = page.locator("#toasts")
    drop(page, office__yaml=text)
    expect(told).to_contain_text("office.yaml is a map without its picture")
    drop(page, office__pgm=picture)
    expect(told).to_contain_text("office.pgm is a picture. Valid are a ROS map's YAML")
    drop(page, office__yaml=text, office__pgm=picture)
    on_field(page, "office")
    assert "image: office.pgm" in (folder / "office.yaml").read_text()


BAD = {
    "text.svg": ("no drawing", "the file is not well-formed XML"),
    "empty.svg": (f'<svg {SVG} width="900mm" height="900mm"/>', "there is no tape"),
    "large.svg": ("<svg>" + 3 * 1024 * 1024 * " ", "the file is too large; valid are up to 2 MB"),
    "notes.docx": ("PK", "notes.docx is no file that this page can open. Valid are"),
}


def test_bad_files_are_refused_by_what_is_valid(page: Page, folder: Path) -> None:
    before = sorted(folder.iterdir())
    for name, (text, words) in BAD.items():
        drop(page, **{name.replace(".", "__"): text})
        expect(page.locator("#toasts")).to_contain_text(words, ignore_case=True)
    assert sorted(folder.iterdir()) == before


def test_who_only_watches_keeps_nothing(browser, tmp_path: Path) -> None:
    config = tmp_path / "settings.toml"
    config.write_text(f'[mapping]\nfolder = "{tmp_path}/fields"\n')
    words = ["run", "--robot", "kinematic", "--map", "square", "--port", "0"]
    words += ["--config", str(config)]
    words += ["--token", "only-for-drivers", "--watch-token", "for-all-others"]
    with started(*words, says=r"(http://[^\s/?]+)") as (_, address):
        context = show_all(browser.new_context())
        context.set_default_timeout(PATIENCE_MS)
        page = context.new_page()
        visit(page, f"{address}/?token=for-all-others")
        drop(page, ring__svg=RING)
        expect(page.locator("#toasts")).to_contain_text("This token only watches.")
        context.close()
    assert not (tmp_path / "fields").exists()
