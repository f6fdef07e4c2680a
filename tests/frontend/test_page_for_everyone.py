"""The page for who sees little, has large thumbs, or works by keys and numbers."""

import re

import pytest
from browsing import change_telemetry, opened, show_all, visit
from playwright.sync_api import expect
from serving import serving, until

pytestmark = [pytest.mark.browser, pytest.mark.slow]


@pytest.fixture(scope="module")
def server():
    with serving("--robot", "kinematic", "--map", "square", "--seed", "3") as running:
        yield running


@pytest.fixture(scope="module")
def page(browser, server):
    yield from opened(browser, server, width=1280, height=720, view=False)


def test_forced_colours_keep_every_state(browser, server):
    for page in opened(browser, server, width=1280, height=720, view=False, forced_colors="active"):
        colour = "e => getComputedStyle(e).backgroundColor"
        for on, off in (
            ("button[data-tool=look]", "[data-tool=place]"),
            ("#plots-tabs [aria-selected=true]", "#plots-tabs [aria-selected=false]"),
            ("#camera-rays", "#camera-profile"),
        ):
            assert page.locator(on).first.evaluate(colour) != page.locator(off).first.evaluate(
                colour
            )
        assert page.locator("#knob").evaluate(colour) != page.locator("#joystick").evaluate(colour)
        image = "e => getComputedStyle(e).backgroundImage"
        assert "gradient" in page.locator("#map .swatch.truth").evaluate(image)


def test_plurals_follow_the_languages_rule(browser, server):
    polish = {
        "language": "pl",
        "plural": "n==1 ? 0 : n%10>=2 && n%10<=4 && (n%100<10 || n%100>=20) ? 1 : 2",
        "point": ",",
        "texts": {"{count} ray": ["{count} promień", "{count} promienie", "{count} promieni"]},
    }
    wanted = ["1 promień", "2 promienie", "5 promieni", "22 promienie"]
    for language, told in {"en": ["1 ray", "2 rays", "5 rays", "22 rays"], "pl": wanted}.items():
        page = browser.new_page()
        page.route("**/api/language/pl.json", lambda route: route.fulfill(json=polish))
        page.goto(f"{server.url}/api/health")
        forms = page.evaluate(
            """async (language) => {
                document.documentElement.lang = language;
                const { tn } = await import("/static/page/language.js");
                return [1, 2, 5, 22].map((n) => tn("{count} ray", "{count} rays", n));
            }""",
            language,
        )
        page.close()
        assert forms == told


def test_on_a_phone_all_targets_are_as_large_as_a_thumb(browser, server):
    for page in opened(browser, server, width=390, height=844, view=False, has_touch=True):
        for tab in ("Camera", "Map", "Filter"):
            page.get_by_role("tab", name=tab).click()
            small = page.evaluate(
                """() => [...document.querySelectorAll('button, select, [type=range], .button')]
                    .filter(e => e.checkVisibility() && e.getBoundingClientRect().height < 43.9)
                    .map(e => `${e.id || e.outerHTML.slice(0, 60)} is too low`)"""
            )
            assert small == [], tab
            if tab == "Map":
                more = page.locator("[data-more-of=map]")
                more.click()
                expect(more).to_have_text("more")
                at = [one.bounding_box() for one in (page.locator("[data-tool=ask]"), more)]
                assert at[0]["y"] == at[1]["y"], "more stands alone"
        plot = page.locator("#plots-canvas").bounding_box()
        assert plot["height"] > 100
        # As low as beside a lesson, the field still has room.
        page.set_viewport_size({"width": 390, "height": 640})
        page.get_by_role("tab", name="Map").click()
        field = page.locator("#map-canvas").bounding_box()
        assert min(field["width"], field["height"]) > 150


SETTING = "A change was not taken: sigma_hit is -3; valid are values from 0.001 to 1."
PICTURE = "A picture came too late to be used: it was exposed before all that is known of the way."


@pytest.mark.parametrize("height", [640, 844])
@pytest.mark.parametrize("language", ["en", "de"])
@pytest.mark.parametrize(
    "problems", [[], [SETTING], [SETTING, PICTURE]], ids=["none", "one", "two"]
)
def test_on_a_phone_the_field_keeps_its_room_below_what_is_told(
    browser, server, height, language, problems
):
    size = {"width": 390, "height": height}
    context = show_all(browser.new_context(viewport=size, locale=language))
    page = context.new_page()
    page.route_web_socket("**/api/live?*", lambda socket: _told(socket, problems))
    visit(page, server.url)
    page.get_by_role("tab", name="Karte" if language == "de" else "Map").click()
    told = page.locator("#banner")
    expect(told).to_have_text(re.compile("." if problems else "^$"))
    # Where the map's panel has little room, it scrolls, and the joystick stays.
    ends = "all => all.forEach((one) => one.scrollTo(0, one.scrollHeight))"
    page.locator("main, #map").evaluate_all(ends)
    field, panel = page.locator("#map-canvas").bounding_box(), page.locator("#map").bounding_box()
    drive = page.locator("#drive").bounding_box()
    assert min(field["width"], field["height"]) >= 150
    assert field["y"] >= panel["y"], "cut above"
    assert field["y"] + field["height"] <= drive["y"], "below the joystick"
    assert drive["y"] + drive["height"] <= height, "the joystick is not in sight"
    context.close()


def _told(socket, problems):
    change_telemetry(socket, lambda message: message.update(problems=problems))


def test_a_skip_link_leads_to_the_map(page):
    page.locator(".skip").first.focus()
    page.keyboard.press("Enter")
    assert page.evaluate("document.activeElement.id") == "map-canvas"


def test_a_pose_is_typed_with_point_or_comma_or_refused(page, server):
    page.locator("#numbers-toggle").click()
    x, heading = page.locator("#pose-x"), page.locator("#pose-heading")
    page.locator("#pose-y").fill("-10.5")
    with server.live() as live:
        for text, metres in (
            ("120,5", 0.1205),
            ("80.25", 0.08025),
            ("\u2212 7", None),
            ("1.000,5", None),
        ):
            x.fill(text)
            valid = x.evaluate("field => field.checkValidity()")
            assert valid == (metres is not None), text
            page.locator("#numbers-place").click()
            if metres is not None:
                at = until(live, lambda now: abs(now["truth"]["x"] - metres) < 1e-6)  # noqa: B023
                assert abs(at["truth"]["y"] + 0.0105) < 1e-6
        x.fill("0")
        heading.fill("400")
        said = heading.evaluate("field => field.validationMessage")
        assert said == "Valid is -360 to 360."
    heading.fill("0")
    page.locator("#home").click()
    page.locator("#numbers-toggle").click()
