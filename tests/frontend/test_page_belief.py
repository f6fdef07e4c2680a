"""What the page says of the filter's belief and of models in files of the user's own."""

import re

import httpx
import pytest
from browsing import change_telemetry, opened
from playwright.sync_api import expect
from serving import ask, serving, until

from app.page.belief import alike
from robot.localization.estimate import State

pytestmark = [pytest.mark.browser, pytest.mark.slow]

MINE = """
import numpy as np

class Mine:
    def log_likelihood(self, poses, scan):
        return np.zeros(len(poses))
"""


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


def test_it_says_when_it_is_certain_and_when_it_knows_nothing(page, live):
    said = page.locator("#map-certainty")
    page.get_by_role("button", name="Figure-eight").click()
    expect(said).to_have_text(re.compile("^certain"))
    page.get_by_role("button", name="STOP").first.click()
    until(live, lambda now: now["mode"] == "idle")
    ask(live, type="pause")
    page.get_by_role("button", name="scatter", exact=True).first.click()
    # Paused, it compares nothing, however far it is driven.
    expect(said).to_have_text("the filter waits")
    ask(live, type="resume")
    expect(said).to_have_text("searching: drive a little")


def claimed(state, radius=None, weights=(), v=0.1):
    count = alike(State(state), weights)
    return {"state": state, "radius": radius, "weights": list(weights), "alike": count, "v": v}


CLAIMS = [
    (claimed("certain", 0.0021, [1.0]), "certain, ± 3 mm"),
    (claimed("certain", 0.003, [0.97, 0.03]), "certain, ± 3 mm"),
    (claimed("certain", None, [1.0]), "certain"),
    (claimed("given", 0.0021, [1.0]), "as given, ± 3 mm"),
    (claimed("given", None, [1.0]), "as given"),
    (claimed("approximate", 0.0571, [1.0]), "about here, ± 58 mm"),
    (claimed("approximate", 0.211, [1.0]), "about here, ± 220 mm"),
    (claimed("ambiguous", None, [0.25] * 4), "four places look alike"),
    (claimed("ambiguous", None, [0.42, 0.4]), "two places look alike, 18 % elsewhere"),
    (claimed("ambiguous", None, [0.5, 0.45]), "two places look alike"),
    (claimed("ambiguous", None, [0.3, 0.28, 0.2, 0.1]), "three places look alike, 12 % elsewhere"),
    (claimed("ambiguous", None, [0.7, 0.1, 0.1]), "probably here: 70 %"),
    (claimed("ambiguous", None, [0.999]), "probably here: > 99 %"),
    (claimed("ambiguous"), "several places look alike"),
    (claimed("searching", None, [0.9]), "searching"),
    (claimed("searching", None, [], v=0.0), "searching: drive a little"),
    (claimed("lost", None, [0.2, 0.1]), "lost: searching"),
    (claimed("lost", None, [0.2], v=0.0), "lost: drive a little"),
]


@pytest.fixture(scope="module")
def told(browser, server):
    """What one page says of each claim; it keeps nothing from one to the next."""
    for page in opened(browser, server, width=1100, height=760, view=False):
        words = page.evaluate(
            """async (claims) => {
                const { certainty } = await import("/static/map/places.js");
                return claims.map(({ weights, v, ...integrity }) => {
                    const hypotheses = weights.map((weight) => ({ weight }));
                    const particles = { hypotheses, alike: integrity.alike };
                    const filter = { paused: false, hand: null };
                    return certainty({ filter, integrity, particles, twist: { v, omega: 0 } });
                });
            }""",
            [claim for claim, _ in CLAIMS],
        )
    return words


@pytest.mark.parametrize("place", range(len(CLAIMS)), ids=[words for _, words in CLAIMS])
def test_each_state_has_its_words(told, place):
    assert told[place] == CLAIMS[place][1]


ASKEW, LATE, SLIP = "is the camera askew?", "pictures seem 30 ms late", "wheels slip"


def telling(socket, claim):
    """Between page and program: telemetry says what ``claim`` holds of integrity."""
    change_telemetry(socket, lambda message: message["integrity"].update(claim))


@pytest.mark.parametrize(("width", "height"), [(1440, 900), (1280, 720), (390, 844)])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_doubts_stand_below_the_words_and_go_away(browser, server, width, height, scheme):
    claim = {"state": "approximate", "radius": 0.06, "heading_bound": 0.2, "alerts": [ASKEW]}
    context = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme)
    page = context.new_page()
    page.route_web_socket("**/api/live?*", lambda socket: telling(socket, claim))
    page.route("**/view/**", lambda route: route.fulfill(body=""))
    page.goto(server.url)
    page.wait_for_function("window.brickpose?.telemetry")
    if width < 640:
        page.get_by_role("tab", name="Map").click()
    words, doubts = page.locator("#map-certainty"), page.locator("#map-doubts")
    expect(words).to_have_text("about here, ± 60 mm")
    expect(words).to_have_attribute("title", re.compile("within 60 mm and 11.5° of"))
    expect(doubts.locator("li")).to_have_text([ASKEW])
    above, below = words.bounding_box(), doubts.bounding_box()
    assert above["y"] + above["height"] <= below["y"] < height
    assert below["x"] >= 0 and below["x"] + below["width"] <= width
    claim["alerts"] = [ASKEW, LATE, SLIP]
    expect(doubts.locator("li")).to_have_text([ASKEW, LATE, "and 1 more"])
    expect(doubts).to_have_attribute("title", re.compile(SLIP))
    claim["alerts"] = []
    expect(doubts).to_be_hidden()
    context.close()


AMBER = """() => {
    const canvas = document.getElementById("map-canvas");
    const top = Math.round(0.7 * canvas.height);
    const box = [0, top, canvas.width, canvas.height - top];
    const { data } = canvas.getContext("2d").getImageData(...box);
    const wanted = [0xa8, 0x62, 0x00];
    let count = 0;
    for (let i = 0; i < data.length; i += 4) {
        if (wanted.every((value, part) => Math.abs(data[i + part] - value) < 12)) count++;
    }
    return count;
}"""
"""Counts the pixels of the map, below the robot, in the colour that marks misplaced tape."""


def test_tape_that_is_not_where_it_is_drawn_is_marked_on_the_map(browser, server):
    shown = {"misplaced_tape": None}
    context = browser.new_context(viewport={"width": 1280, "height": 720})
    page = context.new_page()
    page.route_web_socket(
        "**/api/live?*", lambda socket: change_telemetry(socket, lambda told: told.update(shown))
    )
    page.route("**/view/**", lambda route: route.fulfill(body=""))
    page.goto(server.url)
    page.wait_for_function("window.brickpose?.telemetry")
    assert page.evaluate(AMBER) < 50
    shown["misplaced_tape"] = [(-0.525, -0.525, 0.525, -0.525), (0.475, -0.475, -0.475, -0.475)]
    page.wait_for_function(f"({AMBER})() > 300")
    shown["misplaced_tape"] = None
    page.wait_for_function(f"({AMBER})() < 50")
    context.close()


def test_what_is_claimed_is_drawn_where_it_is_large_enough_to_see(page):
    strokes = page.evaluate(
        """async () => {
            const { drawClaim } = await import("/static/map/drawing.js");
            const canvas = new OffscreenCanvas(200, 200), pose = { x: 100, y: 100, theta: 0 };
            const inked = (radius, heading_bound) => {
                const context = canvas.getContext("2d", { willReadFrequently: true });
                context.reset();
                drawClaim(context, pose, { radius, heading_bound }, 1);
                const { data } = context.getImageData(0, 0, 200, 200);
                const at = (x, y) => data[4 * (200 * y + x) + 3] > 0;
                return [at(100, 60), at(100, 140), at(100, 101)];
            };
            return [inked(40, null), inked(3, 0.001), inked(null, null)];
        }"""
    )
    assert strokes == [[True, True, True], [False, False, False], [False, False, False]]


@pytest.mark.parametrize("kind", ["particles", "kalman", "grid", "hypotheses"])
def test_the_filter_is_changed_while_it_runs(page, live, kind):
    page.get_by_role("button", name="Figure-eight").click()
    filters = page.locator("select[name=filter]")
    filters.select_option("kalman" if kind == "particles" else "particles")
    filters.select_option(kind)
    before = until(live, lambda now: now["twist"]["v"] > 0.1)
    ticks = before["filter"]["updates"] + 10
    until(live, lambda now: now["filter"]["updates"] > ticks and now["estimate"])
    expect(filters).to_have_value(kind)
    expect(page.locator("#map-certainty")).to_have_text(re.compile("^certain"))


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
    page.get_by_role("button", name="Figure-eight").click()
    until(live, lambda now: now["mode"] == "figure_eight")
    (folder / "mine.py").write_text(MINE.replace("zeros", "zerros"))
    expect(banner).to_contain_text("The robot stands still: mine.py line 6: AttributeError")
    until(live, lambda now: now["twist"]["v"] == 0)
    (folder / "mine.py").write_text(MINE)
    # It rates all places alike, which its trial finds; but it works.
    expect(banner).to_contain_text("the model rates a place 50 mm or 23° beside the true one")
    until(live, lambda now: now["twist"]["v"] > 0.1)
    page.get_by_role("button", name="STOP").first.click()
    models.select_option("likelihood_field")
    expect(models).to_have_value("likelihood_field")
    expect(banner).to_be_empty()


def test_a_model_dropped_into_the_folder_appears_in_the_list(page, folder):
    (folder / "another.py").write_text(MINE.replace("Mine", "Another"))
    models = page.get_by_role("combobox", name=re.compile("laser_model_type"))
    expect(models.locator("optgroup option")).to_have_text(["another.py:Another", "mine.py:Mine"])
