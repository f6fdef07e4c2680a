"""The Build HAT's reset pin, on pins that are none."""

import inspect
import sys
from types import SimpleNamespace

import fake_gpiod
import pytest
from fake_gpiod import Direction, Pins

from robot.hat.start.reset_line import GpioResetLine, ResetError


@pytest.fixture
def pins(monkeypatch):
    pins = Pins()
    monkeypatch.setitem(sys.modules, "gpiod", pins.module())
    yield pins
    assert pins.opened == 0, "a chip or a line is still held"


@pytest.fixture
def plug(pins, tmp_path):
    """Plugs chips in, by their names and lines."""

    def plug(**chips):
        for name, lines in chips.items():
            (tmp_path / name).touch()
            pins.add(tmp_path / name, lines)
        return GpioResetLine(lambda seconds: None, tmp_path)

    return plug


MODELS = {
    "Pi 4": {"gpiochip0": fake_gpiod.PI_4, "gpiochip1": fake_gpiod.EXPANDER},
    "Pi 4, older kernel": {"gpiochip0": fake_gpiod.PI_4_MAINLINE},
    "Pi 5": {"gpiochip0": fake_gpiod.PI_4, "gpiochip10": fake_gpiod.PI_5_POWER},
    "Pi 5, older kernel": {"gpiochip0": fake_gpiod.PI_5_POWER, "gpiochip4": fake_gpiod.PI_4},
}


@pytest.mark.parametrize("model", MODELS)
def test_reset_is_low_for_ten_milliseconds_while_boot0_is_low_and_both_are_let_go(
    pins, plug, tmp_path, model
):
    plug(**MODELS[model])
    reset = pins.line("GPIO_GCLK" if model == "Pi 4, older kernel" else "GPIO4")
    boot0 = pins.line("GPIO22")
    seen = []

    def watch(seconds):
        assert reset.direction is boot0.direction is Direction.OUTPUT
        seen.append((seconds, boot0.value, reset.value))

    line = GpioResetLine(watch, tmp_path)
    line.check()
    assert seen == []
    line.pulse()
    assert seen == [(0.01, 0, 0), (0.01, 0, 1)]
    for one in (reset, boot0):
        assert (one.direction, one.value, one.consumer) == (Direction.INPUT, 1, None)


def test_the_pins_are_free_for_the_next_time(plug):
    line = plug(gpiochip0=fake_gpiod.PI_4)
    line.pulse()
    line.pulse()


@pytest.mark.parametrize("way", ["pulse", "check"])
@pytest.mark.parametrize("name", ["GPIO4", "GPIO22"])
@pytest.mark.parametrize(
    ("holder", "cure"), [("onewire@0", "switch 1-Wire off"), ("lg", "end the program")]
)
def test_who_holds_a_line_is_named(pins, plug, way, name, holder, cure):
    line = plug(gpiochip0=fake_gpiod.PI_4)
    pins.line(name).consumer = holder
    with pytest.raises(ResetError, match=f"{name} is held by '{holder}'; {cure}"):
        getattr(line, way)()
    assert pins.line(name).direction is Direction.INPUT


def test_a_line_that_the_kernel_does_not_drive_is_told(plug, monkeypatch):
    def request_lines(self, config, consumer=None):
        raise OSError(22, "Invalid argument")

    monkeypatch.setattr(fake_gpiod.Chip, "request_lines", request_lines)
    with pytest.raises(ResetError, match=r"cannot be driven.*Invalid argument.*reboot"):
        plug(gpiochip0=fake_gpiod.PI_4).pulse()


def test_without_permission_the_group_is_named(pins, plug, tmp_path):
    line = plug(gpiochip0=fake_gpiod.PI_4)
    pins.forbidden = {str(tmp_path / "gpiochip0")}
    with pytest.raises(ResetError, match="usermod -aG gpio"):
        line.pulse()


def test_a_forbidden_chip_beside_the_right_one_does_no_harm(pins, plug, tmp_path):
    line = plug(gpiochip0=fake_gpiod.EXPANDER, gpiochip4=fake_gpiod.PI_4)
    pins.forbidden = {str(tmp_path / "gpiochip0")}
    line.pulse()


def test_what_is_no_chip_is_passed_over(pins, plug, tmp_path):
    line = plug(gpiochip4=fake_gpiod.PI_4)
    (tmp_path / "gpiochip0").touch()
    line.pulse()


def test_another_computer_has_no_such_pin(plug):
    with pytest.raises(ResetError, match=r"there is no .*gpiochip.*Raspberry Pi"):
        plug().pulse()
    with pytest.raises(ResetError, match=r"has the lines GPIO4 and GPIO22.*Raspberry Pi"):
        plug(gpiochip0=[f"PA{number}" for number in range(32)]).pulse()


def test_without_gpiod_it_says_what_to_install(plug, monkeypatch):
    line = plug(gpiochip0=fake_gpiod.PI_4)
    for missing in (None, SimpleNamespace(Chip=object)):  # none, and Debian 12's version 1
        monkeypatch.setitem(sys.modules, "gpiod", missing)
        with pytest.raises(ResetError, match="pip install 'gpiod>=2'"):
            line.pulse()


def test_the_pins_of_these_tests_are_those_of_the_library():
    real = pytest.importorskip("gpiod", exc_type=ImportError)
    for fake in (fake_gpiod.Chip, fake_gpiod.LineRequest):
        library = getattr(real, fake.__name__)
        assert {"__enter__", "__exit__"} <= vars(library).keys()
        for name, method in vars(fake).items():
            if not name.startswith("_"):
                mine = list(inspect.signature(method).parameters)
                theirs = inspect.signature(getattr(library, name)).parameters
                assert mine == list(theirs)[: len(mine)], name
    for fake in (fake_gpiod.LineInfo, fake_gpiod.LineSettings):
        theirs = getattr(real, fake.__name__).__annotations__
        assert fake.__annotations__.keys() <= theirs.keys()
    for fake in (fake_gpiod.Direction, fake_gpiod.Value):
        assert [one.name for one in fake] == [one.name for one in getattr(real.line, fake.__name__)]


def test_the_library_itself_finds_no_pins_in_what_is_no_chip(tmp_path):
    pytest.importorskip("gpiod", exc_type=ImportError)
    (tmp_path / "gpiochip0").symlink_to("/dev/null")
    (tmp_path / "gpiochip1").symlink_to(tmp_path / "gone")
    with pytest.raises(ResetError, match="has the lines GPIO4 and GPIO22"):
        GpioResetLine(devices=tmp_path).pulse()
