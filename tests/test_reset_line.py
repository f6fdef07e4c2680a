"""The Build HAT's reset pin, on gpiozero's pins that are none."""

import sys
from types import SimpleNamespace

import pytest
from gpiozero.pins.mock import MockFactory

from robot.hat.start.reset_line import GpioResetLine, ResetError


@pytest.fixture
def pins(monkeypatch):
    """Pins that remember; the library would take the Pi's own otherwise."""
    import gpiozero

    factory = MockFactory()
    monkeypatch.setattr(gpiozero.Device, "pin_factory", factory)
    yield factory
    factory.close()


def test_reset_is_low_for_ten_milliseconds_while_boot0_is_low_and_both_are_let_go(pins):
    seen = []

    def watch(seconds):
        seen.append((seconds, pins.pin(22).state, pins.pin(4).state))

    GpioResetLine(watch).pulse()
    assert seen == [(0.01, 0, 0), (0.01, 0, 1)]
    assert {pins.pin(number).function for number in (4, 22)} == {"input"}


def test_the_pins_are_free_for_the_next_time(pins):
    line = GpioResetLine(lambda seconds: None)
    line.pulse()
    line.pulse()


def test_a_pin_that_this_program_holds_is_told(pins):
    import gpiozero

    with (
        gpiozero.DigitalOutputDevice(4),
        pytest.raises(ResetError, match=r"no pin to reset the board.*in use"),
    ):
        GpioResetLine(lambda seconds: None).pulse()


def test_without_gpiozero_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "gpiozero", None)
    with pytest.raises(ResetError, match="pip install gpiozero lgpio"):
        GpioResetLine().pulse()


def test_a_pin_that_the_kernel_holds_is_told_with_one_wire(monkeypatch):
    class BusyError(Exception):
        """As the driver below gpiozero raises it."""

    def busy(pin):
        raise BusyError("GPIO busy")

    broken = SimpleNamespace(GPIOZeroError=ValueError, DigitalOutputDevice=busy)
    monkeypatch.setitem(sys.modules, "gpiozero", broken)
    with pytest.raises(ResetError, match=r"GPIO busy.*1-Wire"):
        GpioResetLine().pulse()
