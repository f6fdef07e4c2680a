"""Keys whose release the page is not told of: the robot does not drive on."""

import pytest
from browsing import opened
from serving import serving, until

pytestmark = [pytest.mark.browser, pytest.mark.real_time]

KEYS = {
    "w": ("KeyW", 87),
    "s": ("KeyS", 83),
    "a": ("KeyA", 65),
    "d": ("KeyD", 68),
    "ArrowUp": ("ArrowUp", 38),
    "ArrowDown": ("ArrowDown", 40),
    "ArrowLeft": ("ArrowLeft", 37),
    "ArrowRight": ("ArrowRight", 39),
}
META, COMMAND = ("MetaLeft", 91), 4
"""The key, and its bit in ``modifiers`` while it is held."""
STANDS_S = 0.6


@pytest.fixture(scope="module")
def server():
    with serving("--map", "square", "--seed", "3") as running:
        yield running


@pytest.fixture
def live(server):
    with server.live() as socket:
        yield socket


@pytest.fixture(scope="module")
def page(browser, server):
    yield from opened(browser, server, width=1100, height=760, view=False)


@pytest.fixture
def press(page):
    """Send key events as the system does, which no robot's driver would order so."""
    session = page.context.new_cdp_session(page)

    def send(kind, key, modifiers=0, repeat=False):
        code, number = META if key == "Meta" else KEYS[key]
        session.send(
            "Input.dispatchKeyEvent",
            {
                "type": kind,
                "key": key,
                "code": code,
                "windowsVirtualKeyCode": number,
                "modifiers": modifiers,
                "autoRepeat": repeat,
            },
        )

    return send


def drives(now):
    return abs(now["twist"]["v"]) > 0.05 or abs(now["twist"]["omega"]) > 0.3


def stands(now):
    return now["twist"]["v"] == 0 and now["twist"]["omega"] == 0


def require_standing(live):
    """It stands soon, and stays so for longer than a command holds."""
    begun = until(live, stands)["stamp"]
    until(live, lambda now: not stands(now) or now["stamp"] > begun + STANDS_S)
    assert stands(until(live, lambda now: True))


@pytest.mark.parametrize("keys", [*[[key] for key in KEYS], ["w", "a"], ["ArrowUp", "ArrowRight"]])
def test_command_held_while_keys_are_let_go(press, live, keys):
    """A Mac sends no keyup of a key that is let go while Cmd is held."""
    for key in keys:
        press("rawKeyDown", key)
    until(live, drives)
    press("rawKeyDown", "Meta", COMMAND)
    press("keyUp", "Meta")
    require_standing(live)
    # The next press drives, and its release stops.
    press("rawKeyDown", keys[0])
    until(live, drives)
    press("keyUp", keys[0])
    require_standing(live)


def test_a_key_that_is_pressed_while_command_is_held_is_no_drive_key(press, live):
    press("rawKeyDown", "w")
    until(live, drives)
    press("rawKeyDown", "a", COMMAND)  # the page was told of Cmd by this key alone
    require_standing(live)
    press("keyUp", "w")


def test_a_key_that_still_repeats_must_be_pressed_anew(press, live):
    press("rawKeyDown", "w")
    until(live, drives)
    press("rawKeyDown", "Meta", COMMAND)
    press("keyUp", "Meta")
    for _ in range(3):
        press("rawKeyDown", "w", repeat=True)
    require_standing(live)
    press("keyUp", "w")


@pytest.mark.parametrize("taker", ["contextmenu", "dragstart", "compositionstart", "beforeprint"])
def test_something_else_takes_the_keyboard(page, press, live, taker):
    press("rawKeyDown", "w")
    until(live, drives)
    page.evaluate(f"document.body.dispatchEvent(new Event('{taker}', {{bubbles: true}}))")
    require_standing(live)
    press("keyUp", "w")


def test_the_right_button_opens_a_menu_that_gets_the_keyup(page, press, live):
    press("rawKeyDown", "w")
    until(live, drives)
    page.mouse.click(300, 400, button="right")
    require_standing(live)
    press("keyUp", "w")


def test_a_list_or_a_number_that_gets_the_focus_ends_driving(page, press, live):
    page.get_by_role("button", name="type a pose").click()
    for element in ("select", "#pose-x"):
        press("rawKeyDown", "w")
        until(live, drives)
        page.locator(element).locator("visible=true").first.focus()
        require_standing(live)
        page.evaluate("document.activeElement.blur()")
        press("keyUp", "w")


def test_two_keys_of_which_one_is_let_go_drive_on(press, live):
    """Repeats come from the newest key alone, and end with it: they are no sign of the other."""
    press("rawKeyDown", "w")
    press("rawKeyDown", "a")
    for _ in range(5):
        press("rawKeyDown", "a", repeat=True)
    until(live, lambda now: now["twist"]["v"] > 0.1 and now["twist"]["omega"] > 0.3)
    press("keyUp", "a")
    begun = until(live, lambda now: now["twist"]["omega"] == 0)["stamp"]
    until(live, lambda now: now["twist"]["v"] < 0.1 or now["stamp"] > begun + 2.0)
    assert until(live, lambda now: True)["twist"]["v"] > 0.1
    press("keyUp", "w")
    require_standing(live)
