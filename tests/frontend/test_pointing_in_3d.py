"""The map's tools for poses in the 3D view: where is pressed there, on the floor, is the pose."""

import json
import math
import re

import cv2
import httpx
import numpy as np
import pytest
from browsing import SOFTWARE_GL, opened
from playwright.sync_api import expect
from serving import ask, serving, until
from viser.transforms import SO3

pytestmark = [pytest.mark.browser, pytest.mark.slow]

ARRIVED = re.compile("^goal: arrived(; its (place|heading) is known to .* only)?$")
TAPE, WIDTH = 0.5, 0.05
"""The square's tape: from its middle line to the field's middle, and its width [m]."""


@pytest.fixture(scope="module")
def server():
    with serving("--robot", "sim", "--map", "square", "--seed", "3") as running:
        yield running


@pytest.fixture(scope="module")
def page(chromium, server):
    browser = chromium(SOFTWARE_GL)
    for page in opened(browser, server, width=700, height=560, view=True, has_touch=True):
        page.locator("#view .enlarge").click()
        page.wait_for_function("document.getElementById('view-message').hidden")
        while asked_camera(page, server).status_code == 404:  # viser's client comes later
            page.wait_for_timeout(250)
        yield page
    browser.close()


@pytest.fixture(autouse=True)
def nothing_is_chosen(page):
    yield
    page.locator("button[data-tool=look]").dispatch_event("click")
    # A journey that somebody else stops leaves a message, which lies over the scene.
    page.locator("#journey-cancel").dispatch_event("click")
    page.wait_for_function("window.brickpose.telemetry.mode === 'idle'")


@pytest.fixture
def above(page, server):
    """The camera looks from above, and the picture shows it."""
    page.locator("[data-look=top]").click()
    still(page, server)


def choose(page, tool):
    page.locator(f"[data-scene-tool={tool}]").click()
    expect(page.locator(f"button[data-tool={tool}]")).to_have_attribute("aria-pressed", "true")


def asked_camera(page, server):
    name = page.locator("#view-stage iframe").get_attribute("src").split("/")[1]
    return httpx.post(f"{server.url}/api/view/{name}/free", timeout=30)


def press_for_goals(page, name):
    """Press what belongs to goals; it is beside the map, which the enlarged scene hides."""
    button = page.locator("#planning").get_by_text(name, exact=True)
    expect(button).to_have_count(1)
    button.dispatch_event("click")


def camera(page, server):
    """What the page's viewer sees, as its program knows it."""
    answer = asked_camera(page, server)
    assert answer.status_code == 200
    return answer.json()


def still(page, server):
    """Wait until the camera rests, and the picture is of what it sees; return the camera."""
    seen, count = camera(page, server), 0
    while count < 4:
        page.wait_for_timeout(500)  # longer than the pause between two pictures in software
        before, seen = seen, camera(page, server)
        count = count + 1 if before == seen else 0
    return seen


def moved(page, server, before):
    """Wait until the camera is elsewhere, which is late on a busy machine; return it at rest."""
    while camera(page, server)["position"] == before["position"]:
        page.wait_for_timeout(100)
    return still(page, server)


def rays(page, camera, pixels):
    """Directions (n, 3) in which pixels (n, 2) of the page are seen."""
    focal = page.locator("#view-stage").bounding_box()["height"] / 2 / math.tan(camera["fov"] / 2)
    away = np.column_stack([(np.array(pixels) - middle(page)) / focal, np.ones(len(pixels))])
    return away @ SO3(np.array(camera["wxyz"])).as_matrix().T


def on_floor(page, camera, pixels):
    """Where pixels (n, 2) of the page show z = 0."""
    away = rays(page, camera, pixels)
    return (np.array(camera["position"]) - away * (camera["position"][2] / away[:, 2:]))[:, :2]


def middle(page, right=0.0, down=0.0):
    """A pixel of the page, so many from the middle of the scene."""
    box = page.locator("#view-stage").bounding_box()
    return box["x"] + box["width"] / 2 + right, box["y"] + box["height"] / 2 + down


def drag(page, start, end):
    page.mouse.move(*start)
    page.mouse.down()
    page.mouse.move(*end, steps=4)
    page.mouse.up()


def told(page, *kinds):
    """Commands of these kinds that the page has sent, but no renewals."""
    commands = [json.loads(text) for text in page.evaluate("window.told")]
    return [each for each in commands if each["type"] in kinds and "sent" not in each]


def next_told(page, kind, count):
    page.wait_for_function(
        """([kind, count]) => window.told.map(text => JSON.parse(text))
            .filter(({ type, sent }) => type === kind && sent === undefined).length > count""",
        arg=[kind, count],
    )
    return told(page, kind)[-1]


def test_the_camera_is_the_picture_s(page, server, above):
    shot = cv2.imdecode(np.frombuffer(page.screenshot(), np.uint8), cv2.IMREAD_GRAYSCALE)
    box = page.locator("#view-stage").bounding_box()
    rows, columns = np.nonzero(shot < 60)
    inside = (rows > box["y"]) & (rows < box["y"] + box["height"])
    pixels = np.column_stack([columns, rows])[inside] + 0.5
    away = np.abs(on_floor(page, camera(page, server), pixels)).max(axis=1)
    assert len(pixels) > 500
    # Some are wheels, and words.
    assert np.mean(np.abs(away - TAPE) < WIDTH / 2 + 0.006) > 0.85


def test_a_drag_in_the_scene_sends_the_robot_there_and_it_arrives(page, server):
    page.locator("[data-look=home]").click()
    seen = still(page, server)
    choose(page, "goal")
    expect(page.locator("#view-say")).to_contain_text("where the robot shall go")
    start, end = middle(page, 40, 10), middle(page, 20, -60)
    place, ahead = on_floor(page, seen, [start, end])
    assert np.abs(place).max() < 0.35
    drag(page, start, end)
    [goal] = next_told(page, "navigate", 0)["poses"]
    assert math.dist((goal["x"], goal["y"]), place) < 0.003
    assert goal["theta"] == pytest.approx(math.atan2(*(ahead - place)[::-1]), abs=0.01)
    expect(page.locator("#view-floor")).to_be_hidden()
    expect(page.locator("#journey-text")).to_have_text(ARRIVED)
    truth = page.evaluate("() => window.brickpose.telemetry.truth")
    assert math.dist((truth["x"], truth["y"]), place) < 0.008
    assert abs(math.remainder(truth["theta"] - goal["theta"], math.tau)) < 0.05


def test_several_goals_are_pressed_in_the_scene(page, server, above):
    seen = still(page, server)
    choose(page, "goal")
    press_for_goals(page, "several")
    before = len(told(page, "navigate"))
    pixels = [middle(page, 30, 20), middle(page, -30, 20)]
    for pixel in pixels:
        drag(page, pixel, pixel)
    assert len(told(page, "navigate")) == before
    press_for_goals(page, "drive to 2 goals")
    goals = next_told(page, "navigate", before)["poses"]
    assert [goal.get("theta") for goal in goals] == [None, None]
    places = np.array([(goal["x"], goal["y"]) for goal in goals])
    assert np.abs(places - on_floor(page, seen, pixels)).max() < 0.003


def test_a_zone_is_drawn_in_the_scene(page, server, above, live):
    seen = still(page, server)
    choose(page, "goal")
    press_for_goals(page, "keep out")
    pixels = [middle(page, 40, -40), middle(page, 70, -75)]
    drag(page, *pixels)
    press_for_goals(page, "remove the zone")
    zones = [each["zones"] for each in told(page, "set_walls")]
    corners = np.array(zones[0][0])
    ends = np.array([corners.min(axis=0), corners.max(axis=0)])
    assert np.abs(ends - on_floor(page, seen, pixels)).max() < 0.003
    until(live, lambda now: now["walls"] > 0)


def test_a_press_without_a_drag_keeps_the_heading_and_escape_abandons(page, server, above):
    choose(page, "set_pose")
    before = len(told(page, "set_pose"))
    page.mouse.move(*middle(page, 40, 10))
    page.mouse.down()
    page.mouse.move(*middle(page, 90, 10))
    page.keyboard.press("Escape")
    page.mouse.up()
    expect(page.locator("#view-floor")).to_be_hidden()
    expect(page.locator("button[data-tool=look]")).to_have_attribute("aria-pressed", "true")
    choose(page, "set_pose")
    believed = page.evaluate("window.brickpose.telemetry.estimate.theta")
    drag(page, middle(page, 5, 5), middle(page, 10, 5))
    pose = next_told(page, "set_pose", before)
    assert len(told(page, "set_pose")) == before + 1
    assert pose["theta"] == pytest.approx(believed, abs=0.02)
    assert (
        math.dist(
            (pose["x"], pose["y"]), on_floor(page, camera(page, server), [middle(page, 5, 5)])[0]
        )
        < 0.003
    )


def test_a_finger_points_out_a_pose_unless_its_press_is_taken_back(page, server, above):
    choose(page, "set_pose")
    before = len(told(page, "set_pose"))
    touches = page.context.new_cdp_session(page)

    def touch(kind, *points):
        given = [{"x": x, "y": y} for x, y in points]
        touches.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": given})

    start, end = middle(page, -20, 15), middle(page, -20, -60)
    touch("touchStart", start)
    touch("touchMove", end)
    touch("touchCancel")
    touch("touchStart", start)
    touch("touchMove", end)
    touch("touchEnd")
    pose = next_told(page, "set_pose", before)
    assert len(told(page, "set_pose")) == before + 1
    place, ahead = on_floor(page, camera(page, server), [start, end])
    assert math.dist((pose["x"], pose["y"]), place) < 0.003
    assert pose["theta"] == pytest.approx(math.atan2(*(ahead - place)[::-1]), abs=0.01)


def test_without_a_tool_a_drag_turns_the_scene_and_with_one_it_does_not(page, server, above):
    kinds = ("navigate", "set_pose", "place")
    turned, sent = still(page, server), len(told(page, *kinds))
    sky = middle(page, 0, 30 - page.locator("#view-stage").bounding_box()["height"] / 2)
    while rays(page, turned, [sky])[0, 2] < 0.05:  # the horizon is not in sight
        before = turned
        drag(page, middle(page), middle(page, 5, -40))
        turned = moved(page, server, before)
        assert turned["position"][2] < before["position"][2]
    assert turned["position"][2] > 0
    assert len(told(page, *kinds)) == sent
    choose(page, "place")
    drag(page, sky, middle(page))
    expect(page.locator("#view-say")).to_contain_text("no floor")
    assert len(told(page, *kinds)) == sent
    assert still(page, server) == turned
    # The wheel reaches the scene.
    page.mouse.wheel(0, -200)
    nearer = moved(page, server, turned)
    assert nearer["position"][2] < 0.97 * turned["position"][2]


def test_a_camera_that_follows_stands_still_while_a_pose_is_pointed_out(page, server, live):
    ask(live, type="place", x=0.0, y=0.0, theta=0.0)
    page.locator("[data-look=follow]").click()
    page.wait_for_timeout(500)
    choose(page, "place")
    before = len(told(page, "place"))
    start = middle(page, 10, -30)
    page.mouse.move(*start)
    with page.expect_response("**/api/view/**/free"):
        page.mouse.down()
    page.mouse.move(*middle(page, 60, -60))
    ask(live, type="place", x=0.1, y=0.2, theta=1.0)
    seen = still(page, server)
    assert seen["position"] == pytest.approx([-0.45, 0.0, 0.4], abs=0.005)
    page.mouse.up()
    pose = next_told(page, "place", before)
    assert math.dist((pose["x"], pose["y"]), on_floor(page, seen, [start])[0]) < 0.003
    behind = [
        pose["x"] - 0.45 * math.cos(pose["theta"]),
        pose["y"] - 0.45 * math.sin(pose["theta"]),
    ]
    page.wait_for_timeout(1000)
    assert camera(page, server)["position"][:2] == pytest.approx(behind, abs=0.01)
    page.locator("[data-look=follow]").click()
