"""What the page says of a robot that moves without forces, and where: in English and German."""

import re

import pytest
from browsing import PATIENCE_MS, show_all, visit
from playwright.sync_api import expect
from serving import serving, started

pytestmark = [pytest.mark.browser, pytest.mark.slow]

CURE = "pip install mujoco-core"
WORDS = {"en": "wheels never spin or lock", "de": "drehen nie durch und blockieren nie"}


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    """A program that was to choose its robot, where no physics engine is installed."""
    folder = tmp_path_factory.mktemp("without_engines")
    missing = "import sys\nsys.modules['pybullet'] = sys.modules['mujoco'] = None\n"
    (folder / "sitecustomize.py").write_text(missing)
    words = ("learn", "1", "--map", "stub", "--port", "0", "--file", str(folder / "my_filter.py"))
    prefix = ("env", f"PYTHONPATH={folder}")
    with started(*words, says=r"(http://[^\s]+)/learn/1", prefix=prefix) as (_, address):
        yield address


@pytest.fixture(params=WORDS)
def page(request, browser):
    context = browser.new_context(locale=request.param, viewport={"width": 1600, "height": 1000})
    show_all(context)
    context.set_default_timeout(PATIENCE_MS)
    made = context.new_page()
    made.route("**/view/**", lambda route: route.fulfill(body="<p>no 3D here</p>"))
    yield made
    context.close()


def words(page):
    return WORDS[page.evaluate("document.documentElement.lang")]


def test_the_first_lesson_says_what_is_missing_and_how_to_have_it(page, address):
    page.goto(f"{address}/learn/1")
    note = page.locator("#engine-missing")
    expect(note).to_be_visible()
    expect(note).to_contain_text(words(page))
    expect(note).to_contain_text(CURE)
    page.goto(f"{address}/learn/2")
    expect(page.locator("#lessons a").nth(8)).to_be_visible()
    expect(note).to_be_hidden()


def test_so_do_the_plot_of_odometry_and_the_faults(page, address):
    visit(page, address)
    note = page.locator("#plots-forces")
    expect(note).to_be_visible()
    expect(note).to_contain_text(CURE)
    page.locator("#plots-values").click()
    odometry = page.get_by_label(re.compile(r"(error of odometry|Fehler der Odometrie)")).first
    odometry.uncheck()
    expect(note).to_be_hidden()
    page.keyboard.press("Escape")
    page.locator("#field-open").click()
    expect(page.locator("#faults-forces")).to_contain_text(words(page))
    expect(page.locator("#faults-engine")).to_contain_text(CURE)
    expect(page.locator("#faults-list .parameter")).to_have_count(19)


@pytest.mark.parametrize("robot", ["kinematic", "auto"])
def test_where_an_engine_is_installed_only_the_faults_say_what_a_chosen_robot_lacks(page, robot):
    pytest.importorskip("mujoco")
    chosen = ("--robot", robot) if robot != "auto" else ()
    with serving("--map", "stub", *chosen) as server:
        visit(page, server.url)
        page.locator("#field-open").click()
        expect(page.locator("#faults-list .parameter")).to_have_count(19)
        expect(page.locator("#faults-forces")).to_be_visible(visible=robot == "kinematic")
        expect(page.locator("#faults-engine")).to_be_hidden()
        expect(page.locator("#plots-forces")).to_be_hidden()
        moved_by = re.compile("." if robot == "auto" else "^$")
        expect(page.locator("#robot-name")).to_have_attribute("title", moved_by)
