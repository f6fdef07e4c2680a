"""No head of the page or of a panel is cut, and nothing in it overlaps, at any usual width."""

from __future__ import annotations

import pytest
from browsing import opened
from playwright.sync_api import Page
from serving import serving

pytestmark = [pytest.mark.browser, pytest.mark.slow]

WIDTHS = (360, 640, 768, 1024, 1366, 1600, 1920, 2560)
LAYOUTS = ("simple", "drive", "understand", "present")
FAULTS = """([layout, text, more]) => {
  document.documentElement.dataset.text = text;
  document.documentElement.dataset.more = more;
  document.querySelector(`[data-layout=${layout}]`).click();
  dispatchEvent(new Event("resize"));
  const faults = [];
  const seen = (one) => one.checkVisibility() && one.getBoundingClientRect().width > 0
    && getComputedStyle(one).clipPath === "none";
  const name = (one) => (one.id || one.textContent.trim() || one.className).slice(0, 24);
  for (const head of document.querySelectorAll(
    ".bar, main > .panel > header, .stage-bar, .beside, .drive-buttons, #plots-legend")) {
    if (!seen(head)) continue;
    const box = head.getBoundingClientRect();
    const where = head.closest(".panel")?.id ?? head.className;
    if (box.right > innerWidth + 1) faults.push(`${where} is wider than the page`);
    const parts = [...head.querySelectorAll("button, a.button, select, h2, .chip, li, dl > div")]
      .filter((one) => seen(one) && !one.closest(".skip, .popover"));
    const boxes = parts.map((one) => one.getBoundingClientRect());
    parts.forEach((one, i) => {
      const own = boxes[i];
      // What a list scrolls to is not cut; a head that scrolls is.
      const scrolls = head.matches(".beside");
      if (own.left < box.left - 1 || own.right > box.right + 1 ||
          (!scrolls && (own.top < box.top - 1 || own.bottom > box.bottom + 1)))
        faults.push(`${where}: ${name(one)} is cut`);
      if (one.scrollWidth > one.clientWidth + 1 && getComputedStyle(one).overflowX === "hidden")
        faults.push(`${where}: the words of ${name(one)} are cut`);
      parts.forEach((other, j) => {
        if (j <= i || one.contains(other) || other.contains(one)) return;
        const across = Math.min(own.right, boxes[j].right) - Math.max(own.left, boxes[j].left);
        const down = Math.min(own.bottom, boxes[j].bottom) - Math.max(own.top, boxes[j].top);
        if (across > 2 && down > 2) faults.push(`${where}: ${name(one)} lies on ${name(other)}`);
      });
    });
  }
  return faults;
}"""


@pytest.fixture(scope="module")
def server():
    with serving("--map", "stub", "--condition", "noisy") as running:
        yield running


@pytest.mark.parametrize("language", ["en-US", "de-DE"])
def test_heads_fit(browser, server, language: str) -> None:
    faults: list[str] = []
    for page in opened(browser, server, width=1366, height=900, view=False, locale=language):
        for width in WIDTHS:
            page.set_viewport_size({"width": width, "height": 844 if width < 641 else 900})
            for layout in LAYOUTS:
                for text in ("normal", "large"):
                    for more in ("", "bar map camera view"):
                        found = faults_of(page, layout, text, more)
                        faults += [f"{width} {layout} {text} {more}: {fault}" for fault in found]
    assert not faults, f"{len(faults)}:\n" + "\n".join(faults[:60])


def faults_of(page: Page, layout: str, text: str, more: str) -> list[str]:
    found: list[str] = page.evaluate(FAULTS, [layout, text, more])
    return found
