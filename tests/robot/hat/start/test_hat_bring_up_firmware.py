"""The start of a Build HAT that needs its firmware, over the emulated board."""

import pytest
from bring_up_rig import PROGRAM, Rig

from robot.hat.start.firmware_image import EXPECTED_VERSION, FirmwareImage, FirmwareImageError
from robot.hat.start.upload import Stage


def test_a_board_in_its_bootloader_gets_its_firmware():
    rig = Rig(warm=False)
    rig.begin()
    assert rig.until(rig.ready, 10) < 3
    assert rig.start.version == EXPECTED_VERSION
    assert not rig.board.in_bootloader
    assert rig.start.trouble is None


def test_the_installed_firmware_takes_little_more_than_its_bytes():
    rig = Rig(warm=False, image=FirmwareImage.installed)
    rig.begin()
    assert rig.until(rig.ready, 10) < 4.5 + 2.5


def lose(times, least):
    """Lose one byte in the middle of something long, so often."""
    left = [times]

    def wounded(data):
        if len(data) < least or left[0] == 0:
            return data
        left[0] -= 1
        return data[: len(data) // 2] + data[len(data) // 2 + 1 :]

    return wounded


def change(times, least):
    left = [times]

    def wounded(data):
        if len(data) < least or left[0] == 0:
            return data
        left[0] -= 1
        at = len(data) // 2
        return data[:at] + bytes([data[at] ^ 1]) + data[at + 1 :]

    return wounded


@pytest.mark.parametrize("wound", [lose(1, 1000), lose(2, 1000), change(1, 1000), change(2, 1000)])
def test_an_upload_that_loses_a_byte_is_done_again(wound):
    rig = Rig(warm=False)
    rig.on_the_way_out = wound
    rig.begin()
    rig.until(rig.ready, 20)
    assert rig.start.trouble is None


@pytest.mark.parametrize("word", [b"clear", b"load", b"signature", b"reboot", b"version", b"list"])
@pytest.mark.parametrize("warm", [True, False])
def test_any_command_may_be_lost(word, warm):
    left = [word]

    def lost(data):
        return b"" if left and word in data and left.pop() else data

    rig = Rig(warm=warm)
    rig.on_the_way_out = lost
    rig.begin()
    rig.until(rig.ready, 30)


def test_a_firmware_that_never_arrives_is_told_and_tried_again_later():
    rig = Rig(warm=False)
    rig.on_the_way_out = lose(3, 1000)
    rig.begin()
    rig.until(lambda: rig.start.stage is Stage.FAILED, 30)
    assert "3 tries: bytes were lost" in rig.start.trouble
    assert not rig.start.ready
    rig.until(rig.ready, 20)
    assert rig.start.trouble is None


def test_a_program_that_died_in_its_upload_leaves_a_board_that_still_starts():
    rig = Rig(warm=False)
    rig.board.advance(0.1)
    rig.board.receive(b"clear\rload 1024 1\r\x02" + b"x" * 500)
    rig.board.advance(0.2)
    rig.begin()
    rig.until(rig.ready, 10)


def test_another_firmware_is_reset_and_replaced():
    rig = Rig(version=1670596313)
    rig.board.receive(PROGRAM)
    rig.board.advance(0.5)
    rig.begin()
    rig.until(lambda: rig.start.trouble is not None, 1)
    assert "1670596313, not 1737564117" in rig.start.trouble
    rig.until(rig.ready, 10)
    assert rig.start.version == EXPECTED_VERSION
    assert rig.start.trouble is None


def test_another_firmware_that_cannot_be_reset_is_told_until_its_power_goes():
    rig = Rig(version=1670596313)
    rig.resets = False
    rig.begin()
    rig.until(lambda: rig.start.stage is Stage.FAILED, 2)
    assert "pin 4 is not free" in rig.start.trouble
    assert "off and on" in rig.start.trouble
    rig.board.reset()
    rig.until(rig.ready, 20)


def test_a_missing_firmware_is_told_with_what_to_install():
    def missing():
        raise FirmwareImageError("not installed; pip install buildhat")

    rig = Rig(warm=False, image=missing)
    rig.begin()
    rig.until(lambda: rig.start.stage is Stage.FAILED, 5)
    assert rig.start.trouble == "not installed; pip install buildhat"


def test_a_board_that_restarts_gets_its_firmware_again():
    rig = Rig()
    rig.begin()
    rig.until(rig.ready, 1)
    rig.board.reset()
    rig.until(lambda: not rig.start.ready, 1)
    assert rig.until(rig.ready, 10) < 3


def test_a_firmware_whose_start_was_not_heard_is_asked():
    rig = Rig(warm=False)
    deaf = {None: (b"D", b"x")}
    rig.on_the_way_in = lambda data: data.replace(*deaf.get(rig.start.version, (b"", b"")))
    rig.begin()
    assert 5 < rig.until(rig.ready, 30) < 12
    assert rig.start.trouble is None
