"""Lesson 3 in a real Chromium, from the prediction to the pass, in both languages."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from browsing import PATIENCE_MS
from course.solutions import ARRAYS
from playwright.sync_api import Browser, Page, expect
from serving import started
from test_lens_browser import NAMELESS

from app.features.course.lesson import lesson_of

pytestmark = [pytest.mark.browser, pytest.mark.slow]
STUB = re.compile(r"def log_weight\(.*?raise NotImplementedError\n", re.DOTALL)
OWN = STUB.pattern.replace("raise NotImplementedError", r"sum\(axis=1\)")
SOLUTION = re.search(OWN, ARRAYS, re.DOTALL)[0]  # type: ignore[index]
WRONG = SOLUTION.replace("np.exp(-", "np.exp(")
WORDS = {
    "en-GB": {
        "title": "How good is this guess?",
        "choice": "B, turned",
        "keep": "Keep my prediction",
        "unkept": "Choose first what you think.",
        "predicted": "You predicted: B, turned – it looks wrong",
        "begun": "Not begun yet.",
        "symptom": "The worst particles win.",
        "passed": "Passed. Now break it.",
    },
    "de-DE": {
        "title": "Wie gut ist diese Vermutung?",
        "choice": "B, gedreht",
        "keep": "Meine Vorhersage festhalten",
        "unkept": "Wähl zuerst, was du glaubst.",
        "predicted": "Deine Vorhersage: B, gedreht – it looks wrong",
        "begun": "Noch nicht begonnen.",
        "symptom": "Die schlechtesten Partikel gewinnen.",
        "passed": "Bestanden. Nun mach es kaputt.",
    },
}


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "my_filter.py"  # of a student each: progress is kept beside it


@pytest.fixture
def address(file) -> Iterator[str]:
    words = ("learn", "3", "--robot", "kinematic", "--map", "stub", "--port", "0")
    says = r"(http://[^\s]+/learn/3)"
    with started(*words, "--file", str(file), says=says) as (_, address):
        yield address


@pytest.fixture(params=WORDS)
def page(request, browser: Browser, address: str) -> Iterator[Page]:
    context = browser.new_context(locale=request.param, viewport={"width": 1100, "height": 760})
    context.set_default_timeout(PATIENCE_MS)
    complaints: list[str] = []
    made = context.new_page()
    made.on("pageerror", lambda error: complaints.append(str(error)))
    # The dashboard has tests of its own.
    made.route(re.compile(r"//[^/]+/$"), lambda route: route.fulfill(body="<p>dashboard</p>"))
    made.goto(address)
    yield made
    context.close()
    assert not complaints


def test_lesson_3_from_the_prediction_to_the_pass(page, file):
    language = page.evaluate("navigator.language")
    words = WORDS[language]
    start = STUB.sub(lambda _: lesson_of(3).stub(), file.read_text())
    start = start.replace(WRONG, lesson_of(3).stub()).replace(SOLUTION, lesson_of(3).stub())
    file.write_text(start)
    expect(page.locator("#title")).to_have_text(f"3. {words['title']}")
    expect(page.locator("#later")).to_be_hidden()
    page.get_by_role("button", name=words["keep"]).click()
    expect(page.locator("#kept")).to_have_text(words["unkept"])
    # By keys alone: the choice, the reason, and the button.
    page.locator("#choices input").first.focus()
    page.keyboard.press("ArrowDown")
    expect(page.get_by_label(words["choice"])).to_be_checked()
    page.keyboard.press("Tab")
    page.keyboard.type("it looks wrong")
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    expect(page.locator(".beside")).to_have_text(words["predicted"])
    expect(page.locator("#state")).to_have_text(words["begun"])
    file.write_text(STUB.sub(lambda _: WRONG, start))
    expect(page.locator("#next-link")).to_be_hidden()
    expect(page.locator("#findings h3")).to_have_text(f"{words['symptom']} S2")
    expect(page.locator("#findings svg")).to_be_visible()
    assert not page.evaluate(NAMELESS)
    file.write_text(STUB.sub(lambda _: SOLUTION, start))
    expect(page.locator("#state")).to_have_text(words["passed"])
    expect(page.locator("#findings li")).to_have_count(0)
    expect(page.locator("#lessons [aria-current]")).to_have_text("3 ✓")
    expect(page.locator("#next-link")).to_have_attribute("href", "learn/4")
    expect(page.locator("#next-link")).to_be_visible()
    page.reload()
    expect(page.locator(".beside")).to_have_text(words["predicted"])


def test_the_file_is_written_in_the_page(page, file):
    german = page.evaluate("navigator.language") == "de-DE"
    solved = STUB.sub(lambda _: SOLUTION, file.read_text())
    file.write_text("def log_weight(predicted, measured, sigma):\n    return 0\n")
    page.locator("#choices input").first.check()
    page.locator("#prediction button").click()
    page.get_by_text("Hier schreiben" if german else "Write it here").click()
    code = page.get_by_label("Deine Datei" if german else "Your file")
    words = page.locator("#editor-words")
    expect(code).to_have_value(re.compile("return 0"))
    expect(page.locator("#gutter")).to_contain_text("1\n2\n3")
    code.press("Control+End")
    # A new line has the indentation of the one before; four more after a colon.
    for line in ("", "def more(a):", "if a:", "return 1"):
        code.press("Enter")
        page.keyboard.type(line)
    expect(words).to_have_text("Noch nicht gespeichert." if german else "Not saved yet.")
    code.press("Control+s")
    expect(words).to_have_text("Gespeichert." if german else "Saved.")
    assert file.read_text().endswith("return 0\n\n\ndef more(a):\n    if a:\n        return 1")
    file.write_text(solved)
    code.press("Enter")
    for _ in range(2):
        code.press("Backspace")
    page.keyboard.type("more()")
    assert code.input_value().endswith("return 1\nmore()")
    page.locator("#editor-save").click()
    told = "Die Datei wurde inzwischen geändert" if german else "The file was changed meanwhile"
    expect(words).to_contain_text(told)
    # The check's findings do not hide it.
    expect(page.locator("#state")).to_have_text(WORDS["de-DE" if german else "en-GB"]["passed"])
    expect(words).to_contain_text(told)
    assert file.read_text() == solved
    page.locator("#editor-load").click()
    expect(code).to_have_value(solved)


def test_at_twice_the_size_nothing_is_cut_off(page):
    page.set_viewport_size({"width": 640, "height": 500})
    expect(page.locator("#title")).to_be_visible()
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    page.locator("#reason").scroll_into_view_if_needed()
    assert page.locator("#reason").bounding_box()["x"] >= 0


def test_the_figure_eight_of_a_lesson_goes_on_until_it_is_stopped(browser, address):
    page = browser.new_page(locale="en-GB")
    page.set_default_timeout(PATIENCE_MS)
    page.on("websocket", lambda socket: socket.on("framesent", lambda text: sent.append(str(text))))
    page.route(re.compile(r"//[^/]+/$"), lambda route: route.fulfill(body="<p>dashboard</p>"))
    sent: list[str] = []
    page.goto(address.replace("/learn/3", "/learn/1"))
    page.locator("#choices input").first.check()
    page.get_by_role("button", name="Keep my prediction").click()
    page.get_by_role("button", name="drive the figure-eight").click()
    page.wait_for_timeout(2000)
    eights = sum('"figure_eight"' in text for text in sent)
    page.get_by_role("button", name="stop", exact=True).click()
    page.wait_for_timeout(300)
    stopped = len(sent)
    page.wait_for_timeout(1000)
    assert eights > 10, "it is renewed; else the robot stands after a third of a second"
    assert not any('"figure_eight"' in text for text in sent[stopped:])
    expect(page.locator("#banner")).to_have_text("")
    page.close()


def test_a_lesson_puts_the_robot_itself_at_the_start_and_ends_what_it_drives(browser, address):
    page = browser.new_page(locale="en-GB")
    page.set_default_timeout(PATIENCE_MS)
    page.goto(address.replace("/learn/3", "/learn/1"))
    page.locator("#choices input").first.check()
    page.get_by_role("button", name="Keep my prediction").click()
    page.get_by_role("button", name="drive the figure-eight").click()
    dashboard = page.frames[1]
    dashboard.wait_for_function("Math.abs(window.brickpose?.telemetry?.truth?.x) > 0.05")
    page.get_by_role("button", name="put it at the start").click()
    dashboard.wait_for_function("brickpose.telemetry.mode === 'idle'")
    before = dashboard.evaluate("brickpose.telemetry.stamp")
    dashboard.wait_for_function("(stamp) => brickpose.telemetry.stamp > stamp + 1", arg=before)
    truth = dashboard.evaluate("brickpose.telemetry.truth")
    assert abs(truth["x"]) + abs(truth["y"]) < 0.002
    expect(page.locator("#banner")).to_have_text("")
    page.close()


def test_a_link_of_another_site_puts_the_robot_nowhere_unasked(browser, address):
    page = browser.new_page(locale="en-GB")
    page.set_default_timeout(PATIENCE_MS)
    sent: list[str] = []
    page.on("websocket", lambda socket: socket.on("framesent", lambda text: sent.append(str(text))))
    page.route(re.compile(r"//[^/]+/$"), lambda route: route.fulfill(body="<p>dashboard</p>"))
    page.add_init_script("window.confirm = (text) => { window.asked = text; return false; };")
    page.goto(f"{address}?guess_x=0.1&guess_y=0.1", referer="http://elsewhere.example/")
    page.wait_for_function("window.asked === 'Put the robot where this link says?'")
    page.locator("#stop").click()
    expect(page.locator("#banner")).to_have_text("")
    assert not any("set_pose" in text for text in sent)
    page.close()
