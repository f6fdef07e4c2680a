"""Two students and the teacher's wall, in real browsers at a real JupyterHub."""

from __future__ import annotations

import csv
import os
import re
import signal
from pathlib import Path

import pytest
from classes import needs_hub, running_class
from course.solutions import ARRAYS
from playwright.sync_api import expect

pytestmark = [pytest.mark.browser, pytest.mark.slow, needs_hub]
DRIVES = "Math.hypot(brickpose.telemetry.twist.v, brickpose.telemetry.twist.omega) > 0.01"


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    with running_class(tmp_path_factory.mktemp("class"), "Ada Lovelace\nJürgen Groß\n") as running:
        yield running


@pytest.fixture(scope="module")
def ada(browser, served):
    return served.enter(browser, "ada-lovelace")


@pytest.fixture(scope="module")
def juergen(browser, served):
    return served.enter(browser, "juergen-gross")


@pytest.fixture(scope="module")
def wall(browser, served, ada, juergen):
    page = browser.new_context(accept_downloads=True).new_page()
    page.set_default_timeout(90_000)
    page.goto(served.link("teacher"))
    page.wait_for_url("**/services/wall/")
    expect(page.locator("article[data-awake=true]")).to_have_count(2)
    return page


def test_the_teacher_freezes_both_and_lets_them_go_on(wall, ada, juergen):
    ada.keyboard.down("w")
    ada.wait_for_function(DRIVES)
    wall.locator("#freeze").click()
    for page in (ada, juergen):
        expect(page.locator("#class-banner")).to_be_visible()
        expect(page.locator("body")).to_contain_text("this link only watches")
    ada.wait_for_function(f"!({DRIVES})")
    ada.keyboard.up("w")
    expect(wall.locator("article[data-frozen=true]")).to_have_count(2)
    wall.locator("#freeze").click()
    for page in (ada, juergen):
        expect(page.locator("#class-banner")).to_have_count(0)
        expect(page.locator("body")).not_to_contain_text("this link only watches")
    ada.keyboard.down("w")
    ada.wait_for_function(DRIVES)
    ada.keyboard.up("w")


def test_a_message_reaches_both_and_a_hand_the_wall(wall, ada, juergen):
    wall.locator("#say input").fill("Five minutes <b>left</b>")
    wall.locator("#say button").click()
    for page in (ada, juergen):
        expect(page.locator("#class-banner")).to_have_text("Five minutes <b>left</b>")
    juergen.evaluate("document.querySelector('#class-hand').click()")
    expect(wall.locator("article[data-login=juergen-gross]")).to_have_attribute("data-hand", "true")
    expect(wall.locator("article[data-login=ada-lovelace]")).to_have_attribute("data-hand", "false")


def test_all_start_at_the_same_place(wall, ada, juergen):
    wall.locator("#place [name=x]").fill("0.1")
    wall.locator("#place [name=theta]").fill("90")
    wall.locator("#place button").click()
    for page in (ada, juergen):
        page.wait_for_function(
            "Math.hypot(brickpose.telemetry.truth.x - 0.1, brickpose.telemetry.truth.y) < 0.005"
            " && Math.abs(brickpose.telemetry.truth.theta - Math.PI / 2) < 0.05"
        )


def test_results_are_collected(wall, served, tmp_path):
    home = served.folder / "students" / "ada-lovelace"
    text = (home / "my_filter.py").read_text(encoding="utf-8")
    own = r"def log_weight\(.*?sum\(axis=1\)\n"
    solution = re.search(own, ARRAYS, re.DOTALL)[0]
    stub = re.compile(r"def log_weight\(.*?raise NotImplementedError\n", re.DOTALL)
    (home / "my_filter.py").write_text(stub.sub(lambda _: solution, text), encoding="utf-8")
    with wall.expect_download(timeout=120_000) as download:
        wall.locator("#collect").click()
    download.value.save_as(tmp_path / "results.csv")
    with (tmp_path / "results.csv").open(newline="", encoding="utf-8") as file:
        rows = {row["file"]: row for row in csv.DictReader(file)}
    assert rows["ada-lovelace/my_filter.py"]["lesson 3"] == "passed"
    assert rows["juergen-gross/my_filter.py"]["lesson 3"] == ""


def test_no_student_enters_the_wall_or_another_ones_robot(served, ada):
    for place in ("services/wall/", "user/juergen-gross/", "user/juergen-gross/learn/1"):
        answer = ada.request.get(f"{served.address}/{place}", headers={"accept": "text/html"})
        assert answer.status == 403, place
    order = ada.request.post(f"{served.address}/services/wall/api/freeze", data={"frozen": True})
    assert order.status in (401, 403)
    assert ada.request.get(f"{served.address}/hub/enter/guessed-key").status == 403


def test_a_server_that_is_killed_is_there_again_with_its_files(served, ada):
    pid = _server_of(served.folder / "students" / "ada-lovelace")
    os.kill(pid, signal.SIGKILL)
    ada.wait_for_function("!window.brickpose?.connected")
    ada.wait_for_function("window.brickpose?.connected && window.brickpose?.telemetry?.estimate")
    assert _server_of(served.folder / "students" / "ada-lovelace") != pid
    assert (served.folder / "students" / "ada-lovelace" / "my_filter.py").is_file()


def _server_of(home: Path) -> int:
    """The first process that works in a student's folder: the server, whose child is control."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            if (folder / "cwd").readlink() == home.resolve():
                found.append(int(folder.name))
        except OSError:
            continue
    return min(found)
