"""Another field, and faults of the simulated robot, from the page and without a restart."""

import pytest
from browsing import opened
from playwright.sync_api import expect
from serving import ask, serving, until

from benchmarks.programs import START_S

pytestmark = [pytest.mark.browser, pytest.mark.slow]


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    saved = tmp_path_factory.mktemp("saved")
    drawing = (
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1000 1000" width="1000mm" '
        'height="1000mm"><path d="M100 100H900V900H100Z" fill="none" stroke="black" '
        'stroke-width="50"/></svg>'
    )
    (saved / "kitchen.svg").write_text(drawing)
    config = saved / "settings.toml"
    config.write_text(f'[mapping]\nfolder = "{saved}"\n')
    arguments = ["--map", "square", "--robot", "sim", "--config", str(config)]
    with serving(*arguments) as running:
        yield running


@pytest.fixture(scope="module")
def page(browser, server):
    yield from opened(browser, server, width=1100, height=760, view=False)


def test_sliders_make_the_robot_worse_and_all_is_mended_again(page, server):
    page.locator("#field-open").click()
    page.locator("#faults-condition").select_option("dark")
    with server.live() as live:
        until(live, lambda now: now["robot"]["faults"] == {"light": 0.3})
        expect(page.locator("#stat-faults")).to_have_text("1 fault")
        number = page.get_by_role("textbox", name="Wheels slip")
        number.fill("0.3")
        number.press("Enter")
        worse = until(live, lambda now: "slip_sd" in now["robot"]["faults"])
        assert worse["robot"]["faults"] == {"light": 0.3, "slip_sd": 0.3}
        # The robot goes on, and still sees tape.
        until(live, lambda now: now["scan"]["stamp"] > worse["stamp"] + 0.2)
        refused = ask(live, type="set_faults", values={"light": 7})
        assert refused["message"] == "camera.light is 7; valid is 0.01 to 1"
        assert "valid are slip_sd" in ask(live, type="set_faults", values={"mood": 1})["message"]
        page.locator("#faults-clear").click()
        until(live, lambda now: now["robot"]["faults"] == {})
    expect(page.locator("#stat-faults")).to_be_hidden()
    page.locator("#field-close").click()


def test_another_field_is_loaded_and_the_page_finds_it(page, server):
    with server.live() as live:
        names = page.evaluate("fetch('/api/fields').then((answer) => answer.json())")["names"]
        assert {"square", "town", "kitchen"} <= set(names)
        refused = ask(live, type="use_field", name="/etc/passwd")
        assert "there is no field" in refused["message"]
        ask(live, type="set_faults", values={"noise": 20})
        ask(live, type="set_parameters", values={"max_particles": 700})
        until(live, lambda now: now["robot"]["faults"] == {"noise": 20})
    page.locator("#field-open").click()
    page.locator("#field-name").fill("kitchen")
    page.locator("#field-load").click()
    expect(page.locator("#stat-field")).to_have_text("kitchen")
    with server.live() as live:
        now = until(live, lambda now: now["map"] == "kitchen" and now["estimate"], START_S)
        # What was set goes on.
        assert now["robot"]["faults"] == {"noise": 20}
        rows = page.evaluate("fetch('/api/parameters').then((answer) => answer.json())")
        assert {row["name"]: row["value"] for row in rows}["max_particles"] == 700
        ask(live, type="use_field", name="generated-17")
    expect(page.locator("#stat-field")).to_have_text("generated-17")
    expect(page.locator("#stat-faults")).to_have_text("1 fault")
