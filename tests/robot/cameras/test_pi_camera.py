"""The Pi camera on a module that behaves as picamera2 says it does."""

import time

import numpy as np
import pytest
from camera_sources import READOUT, AtRest, lens, picture, until
from fake_picamera2 import IMX219_MODES, WHOLE, PiRibbon, mode
from hypothesis import example, given
from hypothesis import strategies as st

from robot.cameras.camera import PictureError, middle_of_exposure, on_monotonic, suspend_time
from robot.cameras.pi_camera import PiCamera
from robot.cameras.settings import CameraSourceSettings

NOW = AtRest.NOW


class Bench(AtRest, PiRibbon):
    def __init__(self, settings=None, **world):
        super().__init__(None, settings, **world)

    def stamp_of(self, **told):
        self.sent.put((picture(0, *self.size), told))
        return self.open().grab(1.0).stamp


def test_the_stamp_is_the_middle_of_the_exposure_of_the_middle_row():
    # The first row came, exposed, 30 ms ago; the middle one came half a readout later.
    told = Bench().stamp_of(SensorTimestamp=round((NOW - 0.030) * 1e9), ExposureTime=8000)
    assert told == pytest.approx(NOW - 0.030 + READOUT / 2 - 0.004, abs=1e-9)


def test_a_stamp_that_counts_the_time_asleep_is_brought_to_the_monotonic_clock():
    asleep = 777.0
    bench = Bench(asleep=asleep)
    told = bench.stamp_of(SensorTimestamp=round((NOW + asleep - 0.03) * 1e9), ExposureTime=0)
    assert told == pytest.approx(NOW - 0.03 + READOUT / 2, abs=1e-9)


def test_a_stamp_of_the_monotonic_clock_is_kept_on_a_machine_that_slept():
    told = Bench(asleep=777.0).stamp_of(SensorTimestamp=round((NOW - 0.03) * 1e9), ExposureTime=0)
    assert told == pytest.approx(NOW - 0.03 + READOUT / 2, abs=1e-9)


@pytest.mark.parametrize("told", [{}, {"SensorTimestamp": 12345}, {"SensorTimestamp": 10**18}])
def test_without_a_stamp_that_can_be_the_arrival_counts(told):
    settings = CameraSourceSettings(exposure_delay=0.07)
    assert Bench(settings).stamp_of(**told) == pytest.approx(NOW - 0.07)


def test_without_an_exposure_time_the_setting_counts():
    bench = Bench(CameraSourceSettings(exposure=0.02))
    told = bench.stamp_of(SensorTimestamp=round(NOW * 1e9))
    assert told == pytest.approx(NOW - 0.01 + READOUT / 2)


@given(
    now=st.floats(10, 1e6),
    age=st.floats(1e-6, 0.9),  # of no age, it may be of the future by rounding
    asleep=st.sampled_from([0.0, 5.0, 3600.0, 1e5]),
    boottime=st.booleans(),
)
@example(now=10.8, age=1e-6, asleep=3600.0, boottime=True)
def test_either_clock_is_told_from_the_other(now, age, asleep, boottime):
    stamp = now - age + (asleep if boottime else 0.0)
    assert on_monotonic(stamp, now, asleep) == pytest.approx(now - age, abs=1e-6)


@given(stamp=st.floats(0, 1e6), exposure=st.floats(0, 0.1), readout=st.floats(0, 0.1))
def test_the_middle_lies_between_the_first_light_and_the_last(stamp, exposure, readout):
    middle = middle_of_exposure(stamp, exposure, readout)
    first_light, last_light = stamp - exposure, stamp + readout
    assert middle == pytest.approx((first_light + last_light) / 2, abs=1e-6)


def test_the_time_asleep_is_not_negative():
    assert suspend_time() > -0.01
    assert time.monotonic() > 0


def test_the_picture_is_the_plane_of_brightness_without_padding():
    bench = Bench()
    sent = picture(3, *bench.size)
    bench.send(sent)
    assert np.array_equal(bench.open().grab(1.0).image, sent)


def test_the_mode_with_the_whole_view_is_taken_and_not_the_nearest_size():
    bench = Bench()
    bench.open()
    configured = bench.opened[0].configuration
    assert configured["sensor"] == {"output_size": (1640, 1232), "bit_depth": 10}
    assert configured["main"] == {"size": bench.size, "format": "YUV420"}


def test_a_quicker_pace_takes_the_widest_view_that_is_quick_enough():
    bench = Bench(CameraSourceSettings(frame_rate=45))
    bench.open()
    assert bench.opened[0].configuration["sensor"]["output_size"] == (1920, 1080)


def test_a_pace_that_is_too_quick_is_refused_with_what_can_be():
    with pytest.raises(PictureError, match=r"at most 103\.33 .*frame_rate is 120"):
        Bench(CameraSourceSettings(frame_rate=120)).open()


def test_modes_of_which_nothing_is_known_are_passed_over():
    bench = Bench(modes=[{"format": "MJPEG"}, *IMX219_MODES])
    bench.open()
    assert bench.opened[0].configuration["sensor"]["output_size"] == (1640, 1232)


def test_a_rate_that_was_rounded_is_quick_enough():
    bench = Bench(modes=[mode(800, 600, 29.99, WHOLE)])
    bench.open()
    assert bench.opened[0].started


def test_the_pace_is_fixed():
    bench = Bench(CameraSourceSettings(frame_rate=25))
    bench.open()
    controls = bench.opened[0].configuration["controls"]
    assert controls == {"FrameDurationLimits": (40000, 40000)}


def test_a_movable_lens_is_held_at_the_distance():
    bench = Bench(CameraSourceSettings(focus_distance=0.25))
    bench.more_controls = {"AfMode": (0, 2, 0)}
    bench.open()
    controls = bench.opened[0].configuration["controls"]
    assert (controls["AfMode"], controls["LensPosition"]) == (0, 4.0)


@pytest.mark.parametrize("rotation", [0, 180])
def test_the_sensor_turns_the_picture(rotation):
    bench = Bench(CameraSourceSettings(rotation=rotation))
    bench.open()
    turned = bench.opened[0].configuration["transform"]
    assert turned.hflip == turned.vflip == (rotation == 180)


def test_buffers_are_given_back_also_after_waits_in_vain():
    bench = Bench()
    device = bench.open()
    free = bench.opened[0].buffers
    for _ in range(3 * free):
        assert device.grab(0.0) is None
        bench.send(picture(0, *bench.size))
        assert device.grab(1.0) is not None
    assert bench.opened[0].buffers == free


def test_a_wait_in_vain_asks_for_no_second_picture():
    bench = Bench()
    device = bench.open()
    asked = []
    bench.opened[0].capture_request = lambda wait: asked.append(wait) or object()
    for _ in range(5):
        assert device.grab(0.0) is None
    assert asked == [False]


def test_a_picamera2_that_is_made_for_another_numpy_is_told_with_the_cure():
    def load(name):
        raise ValueError("numpy.dtype size changed, may indicate binary incompatibility")

    device = PiCamera(lens(), CameraSourceSettings(), load=load)
    with pytest.raises(PictureError, match=r"dtype size changed.*remove .venv"):
        device.open()


def test_without_picamera2_the_cure_is_told():
    def load(name):
        raise ImportError(f"No module named {name!r}")

    device = PiCamera(lens(), CameraSourceSettings(), load=load)
    with pytest.raises(PictureError, match=r"apt install python3-picamera2.*system-site-packages"):
        device.open()


USB = {"Id": "/base/scb/pcie@7d500000/pci@0,0/usb@0,0-1.3:1.0-046d:0825", "Model": "C270", "Num": 0}


@pytest.mark.parametrize("cameras", [(), (USB,)])
def test_without_a_camera_at_the_ribbon_cable_the_cure_is_told(cameras):
    with pytest.raises(PictureError, match="ribbon cable"):
        Bench(cameras=cameras).open()


def test_a_usb_camera_is_passed_over():
    bench = Bench(cameras=(USB, *PiRibbon.cameras))
    bench.open()
    assert bench.opened[0].number == 1


def test_a_camera_that_another_program_uses_is_told():
    with pytest.raises(PictureError, match=r"another program .*busy"):
        Bench(plugged=False).open()


def test_closing_frees_the_camera_and_may_be_done_unopened():
    bench = Bench()
    device = bench.open()
    device.close()
    device.close()
    assert bench.opened[0].closed


def test_it_can_be_opened_again_after_a_request_that_was_never_answered(tmp_path):
    source = PiRibbon(tmp_path)
    source.next()
    source.sent.put(None)
    until(lambda: len(source.opened) == 2)
    assert source.next()
    source.close()
