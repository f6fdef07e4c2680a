"""axe-core, npm's checker of accessibility, run on a page that stands in Chromium."""

from __future__ import annotations

from collections.abc import Sequence

import pytest
from node_peers import MODULES
from playwright.sync_api import Page

SCRIPT = MODULES / "node_modules" / "axe-core" / "axe.min.js"
needs_axe = pytest.mark.skipif(
    not SCRIPT.is_file(), reason="axe-core is not there; `make node-peers` gets it"
)
LOOK_RULES = ("color-contrast", "link-in-text-block", "target-size")
"""The rules that ask for colours and sizes: all that another look of a page changes."""
RUN = """async ([part, rules]) => {
  const result = await axe.run(part, {
    ...(rules && { runOnly: { type: "rule", values: rules } }),
    resultTypes: ["violations"],
    iframes: false, // viser's view is not ours
    rules: { "target-size": { enabled: true } },
  });
  return result.violations.flatMap((rule) =>
    rule.nodes.map(({ html, any, all }) =>
      `${rule.id} (${rule.impact}): ${html.slice(0, 160)} `
      + [...any, ...all].map((one) => one.message)));
}"""


def violations(page: Page, part: str = "html", rules: Sequence[str] = ()) -> list[str]:
    """What axe finds in a part of the page, of any impact: the rule and the element.

    By all rules, or by those that are named.
    """
    if not page.evaluate("'axe' in window"):
        page.add_script_tag(path=SCRIPT)
    found: list[str] = page.evaluate(RUN, [part, list(rules) or None])
    return found
