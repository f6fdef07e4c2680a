"""What the page says of the filter's belief and of models in files of the user's own."""

import math
import re

import httpx
import pytest
from browsing import opened
from playwright.sync_api import expect
from serving import ask, serving, until

pytestmark = [pytest.mark.browser, pytest.mark.real_time]

MINE = """
import numpy as np

class Mine:
    def log_likelihood(self, poses, scan):
        return np.zeros(len(poses))
"""
QUARTERS = [[0.25 * math.cos(a), 0.25 * math.sin(a), a] for a in (0, 1.5708, -3.1415, -1.5708)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("models")
    (path / "mine.py").write_text(MINE)
    (path / "narrow.toml").write_text("[scanner]\ntape_width = 0.048\n")
    return path


@pytest.fixture(scope="module")
def server(folder):
    options = ["--models", str(folder), "--config", str(folder / "narrow.toml")]
    with serving("--robot", "kinematic", "--map", "square", *options) as running:
        yield running


@pytest.fixture
def live(server):
    with server.live() as socket:
        until(socket, lambda now: now["mode"] == "idle")  # the page before this one is gone
        ask(socket, type="place", x=0, y=0, theta=0)  # the start pose that a reset tells
        ask(socket, type="reset")
        yield socket
        ask(socket, type="reset")


@pytest.fixture
def page(browser, server):
    yield from opened(browser, server, width=1100, height=760, view=False)


def test_places_that_look_alike_are_counted_in_words(page, live):
    ask(live, type="pause")
    said = page.locator("#map-certainty")
    ask(live, type="set_particles", poses=QUARTERS)
    expect(said).to_have_text("four places look alike")
    ask(live, type="set_particles", poses=QUARTERS, weights=[0.5, 0.4, 0.05, 0.05])
    expect(said).to_have_text("two places look alike")
    ask(live, type="set_particles", poses=QUARTERS, weights=[0.7, 0.1, 0.1, 0.1])
    expect(said).to_have_text("probably here: 70 %")


def test_it_says_when_it_is_sure_and_when_it_knows_nothing(page, live):
    said = page.locator("#map-certainty")
    page.get_by_role("button", name="Figure-eight").click()
    expect(said).to_have_text("sure", timeout=20_000)
    page.get_by_role("button", name="STOP").first.click()
    until(live, lambda now: now["mode"] == "idle")
    ask(live, type="pause")
    page.get_by_role("button", name="scatter", exact=True).first.click()
    expect(said).to_have_text("looking around: drive a little")


FOUND, GONE, REST = [0.9], [0.2, 0.1], [0.42, 0.4]


MISSING = [
    (([], 0, 0.0), "looking around: drive a little"),
    (([], 0, 0.1), "looking around"),
    ((GONE, 0, 0.1), "lost: looking around"),
    ((GONE, 0, 0.0), "lost: drive a little"),
    ((FOUND, 0, 0.1), "looking around"),  # one wide cloud
    ((FOUND, 1, 0.1), "probably here: 90 %"),
    ((REST, 2, 0.1), "two places look alike, 18 % elsewhere"),
    (([0.5, 0.45], 2, 0.1), "two places look alike"),
]


@pytest.fixture(scope="module")
def told(browser, server):
    """What one page says of each belief; it keeps nothing from one to the next."""
    for page in opened(browser, server, width=1100, height=760, view=False):
        words = page.evaluate(
            """async (beliefs) => {
                const { certainty } = await import("/static/map/places.js");
                const covariance = [1e-6, 0, 0, 0, 1e-6, 0, 0, 0, 1e-4];
                return beliefs.map(([weights, alike, v]) => {
                    const hypotheses = weights.map((weight) => ({ weight, covariance }));
                    const filter = { alike, updates: 1 }, twist = { v, omega: 0 };
                    return certainty({ particles: { hypotheses }, filter, twist }).words;
                });
            }""",
            [belief for belief, _ in MISSING],
        )
    return words


@pytest.mark.parametrize("place", range(len(MISSING)), ids=[words for _, words in MISSING])
def test_weight_that_is_missing_is_told_as_elsewhere(told, place):
    assert told[place] == MISSING[place][1]


@pytest.mark.parametrize("kind", ["particles", "kalman", "grid", "hypotheses"])
def test_the_filter_is_changed_while_it_runs(page, live, kind):
    page.get_by_role("button", name="Figure-eight").click()
    filters = page.locator("select[aria-labelledby=name-filter]")
    filters.select_option("kalman" if kind == "particles" else "particles")
    filters.select_option(kind)
    before = until(live, lambda now: now["twist"]["v"] > 0.1)
    ticks = before["filter"]["updates"] + 10
    until(live, lambda now: now["filter"]["updates"] > ticks and now["estimate"])
    expect(filters).to_have_value(kind)
    expect(page.locator("#map-certainty")).to_have_text("sure", timeout=20_000)


def test_every_group_of_parameters_is_listed_and_opens(page, server):
    groups = page.locator("#parameters details")
    expect(groups.locator("summary h3")).to_have_text(["Motion", "Sensor", "Filter", "Hypotheses"])
    row = page.locator("#name-max_hypotheses")
    expect(row).to_be_hidden()
    page.get_by_text("how places are found, weighed and given up").click()
    expect(row).to_be_visible()
    with httpx.Client(base_url=server.url) as client:
        names = {one["name"] for one in client.get("/api/parameters").json()}
    assert page.locator("#parameters .parameter").count() == len(names)


def test_tape_that_is_measured_otherwise_than_drawn_is_a_question_to_the_camera(page):
    expect(page.locator("#tape")).to_have_text(
        re.compile(r"Tape\s*(49|50|51)\.\d mm camera pitch\?")
    )
    expect(page.locator("#tape")).to_have_attribute("title", re.compile("wider"))


def test_a_model_of_ones_own_is_chosen_broken_told_and_mended(page, live, folder):
    models = page.get_by_role("combobox", name=re.compile("laser_model_type"))
    models.select_option("mine.py:Mine")
    banner = page.locator("#banner")
    (folder / "mine.py").write_text(MINE.replace("zeros", "zerros"))
    expect(banner).to_contain_text("The robot stands still: mine.py line 6: AttributeError")
    page.get_by_role("button", name="Figure-eight").click()
    (folder / "mine.py").write_text(MINE)
    expect(banner).to_be_empty()
    until(live, lambda now: now["twist"]["v"] > 0.1)
    page.get_by_role("button", name="STOP").first.click()
    models.select_option("likelihood_field")
    expect(models).to_have_value("likelihood_field")


def test_a_model_dropped_into_the_folder_appears_in_the_list(page, folder):
    (folder / "another.py").write_text(MINE.replace("Mine", "Another"))
    models = page.get_by_role("combobox", name=re.compile("laser_model_type"))
    expect(models.locator("optgroup option")).to_have_text(
        ["another.py:Another", "mine.py:Mine"], timeout=15_000
    )
