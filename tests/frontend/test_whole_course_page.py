"""The course from the first lesson to the last, by the page alone, as a student goes through it."""

from __future__ import annotations

import ast
import json
import re
from dataclasses import dataclass, field

import pytest
from browsing import PATIENCE_MS
from course.solutions import ARRAYS, KALMAN
from course.steering import ARRAYS as STEERING
from playwright.sync_api import Locator, Page, WebSocket, expect
from serving import started

from app.features.course.lesson import Lesson, lessons

pytestmark = [pytest.mark.browser, pytest.mark.slow]
HEAD = "import math\nimport numpy as np\n"
SOLVED = {
    item.name: ast.unparse(item)
    for item in ast.parse(ARRAYS + KALMAN + STEERING).body
    if isinstance(item, ast.FunctionDef)
}
"""Solutions by the name of the function, as a student writes them at last."""
WORDS = {
    "en-GB": ("Keep my prediction", "Write it here", "Save", "Not begun yet.", "Passed."),
    "de-DE": (
        "Meine Vorhersage festhalten",
        "Hier schreiben",
        "Speichern",
        "Noch nicht begonnen.",
        "Bestanden.",
    ),
}
PRESSED = "en-GB"
"""The language in which each button of the texts is pressed: each language has the same commands in
the same places, see ``test_a_lesson_says_the_same_in_each_language``."""


@pytest.mark.parametrize("language", WORDS)
def test_all_lessons_one_after_the_other(browser, tmp_path, language):
    words = ("learn", "1", "--robot", "kinematic", "--port", "0", "--seed", "1")
    file = ("--file", str(tmp_path / "my_filter.py"))
    with started(*words, *file, says=r"(http://[^\s]+)/learn/1") as (_, address):
        context = browser.new_context(locale=language, viewport={"width": 1366, "height": 768})
        context.set_default_timeout(PATIENCE_MS)
        page, complaints, asked = context.new_page(), [], Asked()
        page.on("websocket", asked.follow)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.route("**/view/**", lambda route: route.fulfill(body="<p>no 3D here</p>"))
        page.goto(f"{address}/learn/1")
        for lesson in lessons():
            _learn(page, lesson, asked, WORDS[language], pressed=language == PRESSED)
            if lesson.number < len(lessons()):
                page.locator("#next-link").click()
        assert not complaints
        context.close()


def _learn(
    page: Page, lesson: Lesson, asked: Asked, words: tuple[str, ...], *, pressed: bool
) -> None:
    """Predict, press what is to be pressed, write the solution, and see that it passes."""
    keep, write, save, unbegun, passed = words
    expect(page.locator("#title")).to_have_text(re.compile(rf"^{lesson.number}\. "))
    page.locator("#choices input").first.check()
    page.get_by_role("button", name=keep).click()
    expect(page.locator("#state")).to_have_text(unbegun)
    watch, *others = page.locator("#sections section").all()
    if pressed:
        _press_all(page, watch, asked)
    page.get_by_text(write, exact=True).click()
    code = page.get_by_label(re.compile("^(Your file|Deine Datei)$"))
    expect(code).to_have_value(re.compile(rf"def {lesson.checks.functions[0]}\("))
    code.fill(_solved(code.input_value(), lesson.checks.functions))
    page.get_by_role("button", name=save, exact=True).click()
    expect(page.locator("#state")).to_contain_text(passed)
    expect(page.locator("#findings li")).to_have_count(0)
    expect(page.locator("#lessons [aria-current]")).to_have_text(f"{lesson.number} ✓")
    for section in others if pressed else ():  # the robot may use what was written
        _press_all(page, section, asked)
    assert asked.refused == [], lesson.number


def _press_all(page: Page, section: Locator, asked: Asked) -> None:
    for button in section.locator("button[data-command]").all():
        _press(page, button, asked)
    page.locator("#stop").click()


def _press(page: Page, button: Locator, asked: Asked) -> None:
    """Press a button of the text; nothing is to be refused."""
    expect(page.locator("#banner")).to_have_text("")
    wanted = json.loads(button.get_attribute("data-command") or "")["type"]
    until_connected(page)
    if wanted == "use_field":  # the page connects again
        with page.expect_websocket(lambda made: "page=lesson" in made.url, timeout=PATIENCE_MS):
            button.click()
        until_connected(page)
    else:
        button.click()
    if wanted in ("figure_eight", "navigate"):  # a stop that is pressed before would refuse it
        page.frames[1].wait_for_function(f"brickpose.telemetry.mode === '{wanted}'")
    expect(page.locator("#banner")).to_have_text("")
    assert asked.refused == [], wanted


def until_connected(page: Page) -> None:
    """Wait until lesson and dashboard hear the robot."""
    expect(page.locator("body")).to_have_attribute("data-link", "open")
    dashboard = page.frame_locator("#dashboard")
    expect(dashboard.locator("body")).to_have_attribute("data-stale", "false")


@dataclass
class Asked:
    """What the robot refuses of a lesson's page."""

    refused: list[str] = field(default_factory=list)

    def follow(self, socket: WebSocket) -> None:
        """Hear a connection of the page, if it is the lesson's own."""
        if "page=lesson" in socket.url:
            socket.on("framereceived", self._hear)

    def _hear(self, text: str) -> None:
        message = json.loads(text)
        if message["type"] == "error":
            self.refused.append(message["message"])


def _solved(source: str, functions: tuple[str, ...]) -> str:
    """A student's file with some of its stubs written."""
    parts = [
        SOLVED[item.name]
        if isinstance(item, ast.FunctionDef) and item.name in functions
        else ast.unparse(item)
        for item in ast.parse(source).body
    ]
    return HEAD + "\n\n".join(parts).replace(HEAD, "")
