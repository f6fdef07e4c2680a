"""Nothing on the page is cut, overlaps or runs out of it, at any usual width, language and size."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from browsing import opened
from playwright.sync_api import Page
from serving import serving, started

pytestmark = [pytest.mark.browser, pytest.mark.slow]

SIZES = (
    *((width, 844) for width in (360, 640)),
    *((width, 900) for width in (768, 1024, 1366, 1600, 1920, 2560)),
    (844, 390),
)
LAYOUTS = ("simple", "drive", "understand", "present")
TEXTS = ("normal", "large", "larger")
"""As the page has them, and half as large again, as a browser's own setting makes them."""
FAULTS = """([layout, text, more]) => {
  const root = document.documentElement;
  root.dataset.text = text === "large" ? "large" : "normal";
  root.style.setProperty("--size", text === "larger" ? "1.5" : "");
  if (text !== "larger") root.style.removeProperty("--size");
  root.dataset.more = more;
  document.querySelector(`[data-layout=${layout}]`)?.click(); // other pages have none
  dispatchEvent(new Event("resize"));
  const faults = new Set();
  const name = (one) =>
    (one.id || one.textContent.trim() || one.className || one.tagName).slice(0, 24);
  const seen = (one) => one.checkVisibility() && one.getBoundingClientRect().width > 0
    && getComputedStyle(one).clipPath === "none" && !one.closest(".skip, .hidden-text");
  const where = (one) => one.closest(".panel")?.id ?? one.closest("[id]")?.id ?? "";
  if (root.scrollWidth > innerWidth + 1) faults.add("the page scrolls to the side");
  const kinds = "button, a.button, select, input, h2, .chip, output, label";
  const parts = [...document.querySelectorAll(kinds)]
    .filter((one) => seen(one) && !one.closest(".handles"));
  const handles = [...document.querySelectorAll(".handles")].filter(seen);
  const all = [...parts, ...handles];
  const boxes = all.map((one) => one.getBoundingClientRect());
  const visible = boxes.map((b, i) => { // cut by what scrolls
    let {left, top, right, bottom} = b;
    for (let up = all[i].parentElement; up; up = up.parentElement) {
      const style = getComputedStyle(up);
      if (style.overflowX !== "visible" || style.overflowY !== "visible") {
        const c = up.getBoundingClientRect();
        left = Math.max(left, c.left); right = Math.min(right, c.right);
        top = Math.max(top, c.top); bottom = Math.min(bottom, c.bottom);
      }
      if (style.position === "fixed") break;
    }
    return {left, top, right, bottom};
  });
  all.forEach((one, i) => {
    const own = visible[i], b = boxes[i];
    const told = (what) => faults.add(`${where(one)}: ${name(one)} ${what}`);
    if (b.right > innerWidth + 1 || b.left < -1) told("is beyond the page");
    if (own.right - own.left < b.width - 1.5 && own.bottom - own.top > 2)
      told("is cut at its side");
    all.forEach((other, j) => {
      if (j <= i || one.contains(other) || other.contains(one)) return;
      const o = visible[j];
      const across = Math.min(own.right, o.right) - Math.max(own.left, o.left);
      const down = Math.min(own.bottom, o.bottom) - Math.max(own.top, o.top);
      if (across > 2 && down > 2) told(`lies on ${name(other)}`);
    });
  });
  for (const more of document.querySelectorAll(".panel > header [data-more-of]")) {
    const others = [...more.closest("header").querySelectorAll(".tools button, .tools a")]
      .filter((other) => other !== more && seen(other));
    const { top, bottom } = more.getBoundingClientRect();
    const beside = others.some((other) => {
      const o = other.getBoundingClientRect();
      return o.top < bottom && o.bottom > top;
    });
    if (seen(more) && others.length > 0 && !beside) faults.add(`${where(more)}: more stands alone`);
  }
  const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const range = document.createRange();
  while (texts.nextNode()) {
    const parent = texts.currentNode.parentElement;
    const silent = "h1, script, noscript, datalist, option, .hidden-text, .skip, .scenes";
    if (!texts.currentNode.data.trim() || parent.closest(silent) || !seen(parent)) continue;
    for (const word of texts.currentNode.data.matchAll(/[^\\s\\-\\u00AD\\/–]+/g)) {
      range.setStart(texts.currentNode, word.index);
      range.setEnd(texts.currentNode, word.index + word[0].length);
      const tops = [...range.getClientRects()].filter((line) => line.width > 0)
        .map((line) => line.top);
      if (tops.length > 1 && Math.max(...tops) - Math.min(...tops) > 2)
        faults.add(`${where(parent)}: the word ${word[0]} of ${name(parent)} is broken`);
    }
    range.selectNodeContents(texts.currentNode);
    for (const line of range.getClientRects()) {
      let {left, top, right, bottom} = line, scrolls = false;
      for (let up = parent; up && up !== document.body; up = up.parentElement) {
        const style = getComputedStyle(up);
        if (style.overflowX === "visible" || style.display === "inline") continue;
        const c = up.getBoundingClientRect();
        left = Math.max(left, c.left); right = Math.min(right, c.right);
        if (!scrolls) { top = Math.max(top, c.top); bottom = Math.min(bottom, c.bottom); }
        scrolls ||= style.overflowY !== "hidden" && style.overflowY !== "clip";
      }
      if (bottom - top < 2) continue;
      const told = (what) => faults.add(`${where(parent)}: words of ${name(parent)} ${what}`);
      if (right - left < line.width - 2) told("are cut at the side");
      if (bottom - top < 0.7 * line.height && !scrolls) told("are cut below");
    }
  }
  return [...faults];
}"""


@pytest.fixture(scope="module")
def server():
    with serving("--map", "stub", "--condition", "noisy") as running:
        yield running


@pytest.mark.parametrize("language", ["en-US", "de-DE"])
def test_nothing_is_cut_and_nothing_overlaps(browser, server, language: str) -> None:
    faults: list[str] = []
    looks = [(layout, text) for layout in LAYOUTS for text in TEXTS]
    for page in opened(browser, server, width=1366, height=900, view=False, locale=language):
        for place, (width, height) in enumerate(SIZES):
            page.set_viewport_size({"width": width, "height": height})
            for turn, (layout, text) in enumerate(looks, place):
                more = ("", "bar map camera view")[turn % 2]  # by turns: both at each size
                found = faults_of(page, layout, text, more)
                faults += [f"{width} {layout} {text} {more}: {fault}" for fault in found]
    assert not faults, f"{len(faults)}:\n" + "\n".join(faults[:60])


@pytest.mark.parametrize("language", ["en-US", "de-DE"])
def test_the_other_pages_are_not_cut_either(browser, server, tmp_path, language: str) -> None:
    faults: list[str] = []
    words = ("learn", "3", "--robot", "kinematic", "--map", "stub", "--port", "0")
    file = str(tmp_path / "my_filter.py")
    with started(*words, "--file", file, says=r"(http://[^\s]+/learn/3)") as (_, lesson):
        for page in opened(browser, server, width=1366, height=900, view=False, locale=language):
            page.route(re.compile(r"//[^/]+/$"), lambda route: route.fulfill(body="dashboard"))
            for address in (f"{server.url}/lens", f"{server.url}/field_editor"):
                faults += faults_at(page, address)
        context = browser.new_context(locale=language)
        page = context.new_page()
        page.route(re.compile(r"//[^/]+/$"), lambda route: route.fulfill(body="dashboard"))
        faults += faults_at(page, lesson)
        context.close()
    assert not faults, f"{len(faults)}:\n" + "\n".join(faults[:60])


def faults_at(page: Page, address: str) -> list[str]:
    page.goto(address)
    page.wait_for_load_state("networkidle" if "learn" in address else "load")
    faults: list[str] = []
    for width, height in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        for text in TEXTS:
            name = f"{width} {Path(address).name} {text}"
            faults += [f"{name}: {fault}" for fault in faults_of(page, "none", text, "")]
    return faults


def faults_of(page: Page, layout: str, text: str, more: str) -> list[str]:
    found: list[str] = page.evaluate(FAULTS, [layout, text, more])
    return found


def test_what_is_cut_or_overlaps_would_be_found(browser, server) -> None:
    for page in opened(browser, server, width=1366, height=900, view=False):
        assert not faults_of(page, "simple", "normal", "")
        cut = "width: 1rem; overflow: hidden; white-space: nowrap"
        page.add_style_tag(content=f"#map-title {{ {cut} }}")
        assert any("map-title" in fault for fault in faults_of(page, "simple", "normal", ""))
        moved = "position: relative; left: 3rem; top: 1rem"
        page.add_style_tag(content=f"#figure-eight {{ {moved} }}")
        found = faults_of(page, "simple", "normal", "")
        assert any("figure-eight" in fault and "lies on" in fault for fault in found)
