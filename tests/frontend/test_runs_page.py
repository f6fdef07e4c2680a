"""The table of runs: what compares and saves them is in sight, however many there are."""

from __future__ import annotations

import pytest
from browsing import opened
from playwright.sync_api import Route, expect
from serving import serving

pytestmark = [pytest.mark.browser, pytest.mark.slow]
RUN = {
    "file": "", "field": "square", "recorded": False, "present": False, "kept": True,
    "parameters": {"sigma_hit": 0.03, "z_rand": 0.2, "filter": "particles"},
    "standard": {"sigma_hit": 0.003, "z_rand": 0.05, "filter": "hypotheses"},
    "units": {"sigma_hit": "m"}, "pictures": 900, "seconds": 30.0, "rmse": 0.0012,
    "median": 0.001, "worst": 0.004, "lost": 0.0, "misleading": 0.0, "time_to_right": 1.2,
    "difference": {"rmse": 0.001, "low": 0.0005, "high": 0.0015},
}  # fmt: skip
MANY = 12


@pytest.fixture(scope="module")
def server():
    with serving("--robot", "kinematic", "--map", "square") as running:
        yield running


def answer(route: Route) -> None:
    runs = [RUN | {"number": number} for number in range(MANY)]
    route.fulfill(json={"runs": runs, "against": 0})


@pytest.mark.parametrize(("width", "height"), [(1366, 768), (768, 1024), (390, 844)])
def test_csv_and_difference_stay_in_sight_below_many_runs(browser, server, width, height) -> None:
    for page in opened(browser, server, width=width, height=height, view=False):
        page.route("**/api/runs?*", answer)
        page.evaluate("document.querySelector('#runs-open').click()")
        expect(page.locator("#runs-body tr")).to_have_count(MANY)
        for part in ("#runs-csv", "#runs-window", "#runs-note", "#runs-close", "#runs thead"):
            expect(page.locator(part)).to_be_in_viewport()
            box = page.locator(part).bounding_box()
            inside = page.locator("#runs").bounding_box()
            assert box["y"] + box["height"] <= inside["y"] + inside["height"] + 1, part
        last = page.locator("#runs-body tr").last
        last.scroll_into_view_if_needed()
        expect(last).to_be_in_viewport()
        expect(page.locator("#runs-csv")).to_be_in_viewport()
