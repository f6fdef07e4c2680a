"""Plots on the page: values chosen, zoomed, saved, kept over a reload."""

import csv
import io
from pathlib import Path
from xml.etree import ElementTree

import cv2
import pytest
from browsing import opened
from playwright.sync_api import expect
from serving import serving

pytestmark = [pytest.mark.browser, pytest.mark.slow]


@pytest.fixture(scope="module")
def server():
    with serving("--robot", "kinematic", "--map", "square") as running:
        yield running


@pytest.fixture
def page(browser, server):
    yield from opened(browser, server, width=1100, height=760, view=False)


def saved(page, kind):
    with page.expect_download() as download:
        page.select_option("#plots-save", kind)
    return Path(download.value.path())


def test_values_are_chosen_and_saved_with_their_units(page):
    page.get_by_role("button", name="values").click()
    page.get_by_label("left wheel").check()
    page.get_by_label("heading error of the estimate").check()
    page.get_by_label("error of odometry", exact=True).uncheck()
    page.keyboard.press("Escape")
    expect(page.locator("#plots-chooser")).to_be_hidden()
    legend = page.locator("#plots-legend")
    expect(legend).to_contain_text("left wheel 0.00 rad/s")
    page.wait_for_function("brickpose.telemetry.stamp > 3")
    rows = list(csv.reader(io.StringIO(saved(page, "csv").read_text())))
    names = [
        "error of the estimate [mm]",
        "heading error of the estimate [°]",
        "left wheel [rad/s]",
    ]
    assert rows[0] == ["stamp [s]", *names]
    assert len(rows) > 10
    stamps = [float(row[0]) for row in rows[1:]]
    assert stamps == sorted(stamps)
    drawn = ElementTree.fromstring(saved(page, "svg").read_text())
    words = {text.text for text in drawn.iter("{http://www.w3.org/2000/svg}text")}
    assert {"mm", "°", "rad/s", "left wheel", "seconds"} <= words
    picture = cv2.imread(str(saved(page, "png")))
    assert picture.shape == (1080, 1920, 3)
    assert picture.std() > 5
    legend.get_by_role("button", name="left wheel").click()
    expect(legend).not_to_contain_text("left wheel")
    assert "left wheel" not in saved(page, "csv").read_text()


def test_axes_end_near_the_largest_value_and_have_room_for_their_numbers(page):
    ends, tight = page.evaluate(
        """async () => {
            const { axisScale, roundEnd } = await import("/static/plots/scale.js");
            const ends = [0.52, 51, 140, 230, 900].map(roundEnd);
            return [ends, axisScale({ low: 0, high: 100, label: "" }, 0, 30, 0.8).ticks];
        }"""
    )
    assert ends == pytest.approx([0.6, 60, 150, 250, 1000])
    assert tight == [0, 100]


def test_the_run_is_zoomed_and_kept_over_a_reload(page):
    began = page.evaluate("brickpose.telemetry.stamp")
    page.wait_for_function("began => brickpose.telemetry.stamp > began + 4", arg=began)
    first = float(saved(page, "csv").read_text().splitlines()[1].split(",")[0])
    canvas = page.locator("#plots-canvas")
    canvas.focus()
    for _ in range(12):
        canvas.press("+")
    zoomed = saved(page, "csv").read_text().splitlines()
    assert float(zoomed[1].split(",")[0]) > first + 0.5
    canvas.press("Shift+ArrowLeft")
    expect(page.locator("#plots-readout")).to_contain_text("s ago")
    page.reload()
    page.wait_for_function("window.brickpose?.telemetry?.estimate")
    page.select_option("#plots-span", "0")
    again = float(saved(page, "csv").read_text().splitlines()[1].split(",")[0])
    assert again == pytest.approx(first, abs=0.3)


def test_a_typed_number_may_have_a_comma_and_is_never_read_as_another(page):
    field = page.locator("#parameters input[inputmode=decimal]").first
    field.fill("3,5")
    field.press("Enter")
    expect(page.locator("#parameters .parameter[data-changed=true] .name")).to_contain_text("sigma")
    expect(field).to_have_value("3.5")
    field.fill("1.000,5")
    field.press("Enter")
    expect(page.locator("#parameters")).to_contain_text("That is not a number.")
    expect(field).to_have_value("3.5")
