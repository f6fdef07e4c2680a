"""Two students and the teacher's wall, in real browsers at a real JupyterHub."""

from __future__ import annotations

import csv
import os
import re
import signal
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pytest
from classes import needs_hub, running_class
from course.solutions import ARRAYS
from engine_runs import kinematic
from playwright.sync_api import expect
from recordings import record

pytestmark = [pytest.mark.browser, pytest.mark.slow, needs_hub]
DRIVES = "Math.hypot(brickpose.telemetry.twist.v, brickpose.telemetry.twist.omega) > 0.01"


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    words = ("--shared-robot", "kinematic")
    folder = tmp_path_factory.mktemp("class")
    with running_class(folder, "Ada Lovelace\nJürgen Groß\n", *words) as running:
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
        expect(page.locator("#drive-who")).to_have_text("The teacher has frozen all robots.")
    ada.wait_for_function(f"!({DRIVES})")
    ada.keyboard.up("w")
    expect(wall.locator("article[data-frozen=true]")).to_have_count(2)
    wall.locator("#freeze").click()
    for page in (ada, juergen):
        expect(page.locator("#class-banner")).to_have_count(0)
        expect(page.locator("#drive-who")).not_to_contain_text("frozen")
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


def test_a_lesson_is_handed_out_and_taken_back(wall, ada, juergen):
    wall.locator("#lesson [name=number]").fill("3")
    wall.locator("#lesson button").click()
    for page in (ada, juergen):
        link = page.locator("#class-banner a")
        expect(link).to_have_text("lesson 3")
        expect(link).to_have_attribute("href", "learn/3")
    wall.locator("#lesson [name=number]").fill("0")
    wall.locator("#lesson button").click()
    for page in (ada, juergen):
        expect(page.locator("#class-banner a")).to_have_count(0)


def test_what_stands_is_told_on_the_wall_and_beside_lessons_and_outlasts_another_field(
    wall, served, ada, juergen
):
    """On a phone the dashboard is below the lesson: words for all stand at the top of the page."""
    wall.locator("#say input").fill("Look at the tape")
    wall.locator("#say button").click()
    expect(wall.locator("#said-words")).to_have_text("All read: Look at the tape")
    expect(wall.locator("#say input")).to_have_value("")
    lesson = ada.context.new_page()
    lesson.set_viewport_size({"width": 390, "height": 844})
    lesson.goto(f"{served.address}/user/ada-lovelace/learn/4")
    expect(lesson.locator("#class-banner")).to_be_in_viewport()
    expect(lesson.frame_locator("#dashboard").locator("#class-banner")).to_have_count(0)
    expect(wall.locator("article[data-login=ada-lovelace]")).to_contain_text("lesson 4")
    bar, told = (
        ada.locator("header.bar").bounding_box(),
        ada.locator("#class-banner").bounding_box(),
    )
    assert bar["y"] >= told["y"] + told["height"] - 1, "STOP stays in sight"
    wall.locator("#field input").fill("nowhere")
    wall.locator("#field button").click()
    expect(wall.locator("#told")).to_contain_text("0 robots are on nowhere now, of 2. there is no")
    wall.locator("#field input").fill("stub")
    wall.locator("#field button").click()
    expect(wall.locator("#told")).to_have_text("2 robots are on stub now, of 2.")
    for page in (ada, juergen):
        page.wait_for_function("window.brickpose?.connected && brickpose.telemetry.map === 'stub'")
        expect(page.locator("#class-banner")).to_have_text("Look at the tape")
    wall.locator("#said-away").click()
    for page in (ada, juergen, lesson):
        expect(page.locator("#class-banner")).to_have_count(0)
    lesson.close()


def test_the_teacher_watches_a_robot_by_one_press(wall):
    with wall.context.expect_page() as opened:
        wall.locator("article[data-login=ada-lovelace] a").click()
    opened.value.wait_for_url("**/user/ada-lovelace/")
    opened.value.wait_for_function("window.brickpose?.telemetry?.estimate")
    opened.value.close()


def test_a_recording_is_handed_out_to_both(wall, served, ada, juergen, tmp_path):
    made, *_ = record(kinematic(), tmp_path, 1.0)
    [file] = made.glob("*.mcap")
    wall.set_input_files("#recording", file)
    expect(wall.locator("#told")).to_have_text("2 robots have it now, of 2.")
    for page, login in ((ada, "ada-lovelace"), (juergen, "juergen-gross")):
        listed = page.request.get(f"{served.address}/user/{login}/api/recordings").text()
        assert file.stem.removesuffix("_0") in listed


def test_the_recordings_of_the_class_are_exported(wall, served, ada, juergen, tmp_path):
    before = {page: page.request.get(f"{served.address}/user/{login}/api/recordings").json()
              for page, login in ((ada, "ada-lovelace"), (juergen, "juergen-gross"))}  # fmt: skip
    with wall.expect_download(timeout=120_000) as download:
        wall.locator("#recordings").click()
    download.value.save_as(tmp_path / "recordings.zip")
    with zipfile.ZipFile(tmp_path / "recordings.zip") as made:
        sizes = {each.filename: each.file_size for each in made.infolist()}
    assert sizes == {
        f"{login}/{each['name']}.mcap": each["size_bytes"]
        for login, entries in zip(("ada-lovelace", "juergen-gross"), before.values(), strict=True)
        for each in entries
    }
    assert len(sizes) == 2, "one was handed out to each"


def test_the_shared_robots_queue_is_on_the_wall_and_on_the_students_own_pages(wall, ada, juergen):
    told = wall.locator("#queue-told")
    expect(told).to_contain_text("Nobody drives")
    expect(ada.locator("#queue-told")).to_have_text("Nobody drives: queue up.")
    ada.evaluate("document.querySelector('#queue-wish').click()")
    expect(ada.locator("#queue-told")).to_have_text("You drive; nobody waits.")
    expect(told).to_contain_text("ada-lovelace drives")
    juergen.evaluate("document.querySelector('#queue-wish').click()")
    expect(juergen.locator("#queue-told")).to_contain_text("ada-lovelace drives")
    expect(told).to_contain_text("1 waits: juergen-gross")
    wall.locator("#queue-login").select_option("juergen-gross")
    wall.locator("#queue-hand").click()
    expect(juergen.locator("#queue-told")).to_contain_text("You drive")
    wall.locator("#queue-skip").click()
    expect(ada.locator("#queue-told")).to_contain_text("You drive")
    assert ada.locator("#queue-robot").get_attribute("href") == "/services/robot/"
    wall.locator("#queue-end").click()
    for page in (ada, juergen):
        expect(page.locator("#queue-told")).to_have_text("The teacher has ended the queue.")
    expect(wall.locator("#queue-end")).to_have_text("Open the queue")


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
    with wall.expect_download() as download:
        wall.locator("#junit").click()
    suites = ElementTree.parse(download.value.path()).getroot()
    assert [each.get("name") for each in suites.iter("testsuite")] == list(rows)


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
