"""The start of a Build HAT, over the emulated board and on its clock."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot.hat.protocol import bootloader_events as boot
from robot.hat.protocol import events as ev
from robot.hat.protocol.decoder import Decoder
from robot.hat.start.bring_up import BringUp
from robot.hat.start.firmware_image import EXPECTED_VERSION, FirmwareImage, FirmwareImageError
from robot.hat.start.stage import Stage
from sim.hat.devices.lego_motor import LegoMotor
from sim.hat.devices.plants import FreeMotors
from sim.hat.emulated_board import EmulatedBoard

STEP = 0.01
IMAGE = FirmwareImage(EXPECTED_VERSION, bytes(range(256)) * 4, b"\x0d" * 64)
PROGRAM = b"port 0;port_plimit 1;pwm;set 1;select 2;selrate 10\r"


class Rig:
    """A board and the start of it, both on the board's clock."""

    def __init__(self, *, warm=True, version=EXPECTED_VERSION, image=lambda: IMAGE):
        plants = FreeMotors()
        motor = LegoMotor(0x30, plants.plant(0))
        self.board = EmulatedBoard(plants, {0: motor}, warm=warm, version=version)
        self.start = BringUp(image)
        self.decoder = Decoder()
        self.sent = []
        self.on_the_way_out = lambda data: data
        self.on_the_way_in = lambda data: data
        self.resets = True

    def begin(self):
        self._send(self.start.begin(self.board.now))

    def _send(self, data):
        if data:
            self.sent.append(data)
            self.board.receive(self.on_the_way_out(data))

    def step(self):
        heard = self.on_the_way_in(self.board.advance(STEP))
        now = self.board.now
        self._send(self.start.receive(self.decoder.feed(heard), now))
        self._send(self.start.tick(now))
        if self.start.wants_reset:
            if self.resets:
                self.board.reset()
                self.start.was_reset(now)
            else:
                self.start.cannot_reset("pin 4 is not free", now)

    def until(self, condition, limit):
        """Let time pass until something is so; how long it took [s]."""
        begin = self.board.now
        while not condition():
            assert self.board.now - begin < limit, (self.start.stage, self.start.trouble)
            self.step()
        return self.board.now - begin

    def ready(self):
        return self.start.ready

    def run(self, seconds):
        end = self.board.now + seconds
        self.until(lambda: self.board.now > end, seconds + 1)


def test_a_board_that_runs_is_ready_at_once():
    rig = Rig()
    rig.begin()
    assert rig.until(rig.ready, 1) < 0.3
    assert rig.start.version == EXPECTED_VERSION
    assert (rig.start.stage, rig.start.trouble) == (Stage.RUNNING, None)


def test_a_running_motor_stops_with_the_first_words():
    rig = Rig()
    rig.board.receive(PROGRAM)
    rig.board.advance(1)
    assert rig.board.duty(0) == 1
    rig.begin()
    rig.run(0.03)
    assert rig.board.duty(0) == 0
    rig.until(rig.ready, 1)
    assert rig.board.duty(0) == 0


@pytest.mark.parametrize(
    "left", [b"port 0;pwm;set 1", b"port 0;set pulse 1 0 2", b"x" * 300, b"\n", b"port 0;pwm;set"]
)
def test_a_line_that_another_program_left_half_sent_does_no_harm(left):
    rig = Rig()
    rig.board.receive(PROGRAM + left)
    rig.board.advance(0.5)
    rig.begin()
    rig.until(rig.ready, 1)
    assert rig.board.duty(0) == 0


def test_a_motor_under_a_position_loop_is_not_driven_home():
    rig = Rig()
    rig.board.receive(PROGRAM)
    rig.board.advance(0.5)
    rig.board.receive(b"combi 0 1 0 2 0 3 0;select 0;pid 0 0 1 s4 .00277778 0 5 0 .1 3 .01;set 3\r")
    rig.board.advance(0.5)
    rig.begin()
    rig.until(rig.ready, 1)
    rig.run(0.5)
    assert rig.board.duty(0) == 0


def test_reports_echo_and_traces_of_another_program_end():
    rig = Rig()
    rig.board.receive(PROGRAM + b"echo 1\rdebug 16\r")
    rig.board.advance(0.5)
    rig.begin()
    rig.until(rig.ready, 2)
    assert rig.board.advance(1) == b""


def test_a_board_that_is_ready_is_left_alone():
    rig = Rig()
    rig.begin()
    rig.until(rig.ready, 1)
    rig.sent.clear()
    rig.run(3)
    assert rig.sent == []


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


def test_a_silent_board_is_told_after_some_seconds_and_asked_for_ever():
    rig = Rig()
    rig.board.silent = True
    rig.begin()
    rig.run(2.5)
    assert rig.start.trouble is None
    rig.run(1.5)
    for cure in ("8 V", "login shell", "/dev/ttyAMA0", "1-Wire"):
        assert cure in rig.start.trouble
    rig.sent.clear()
    rig.run(30)
    assert 24 <= len(rig.sent) <= 26
    assert not rig.start.ready
    rig.board.silent = False
    rig.until(rig.ready, 2)
    assert rig.start.trouble is None


@pytest.mark.parametrize(
    ("said", "cure"),
    [
        (b"\r\nDebian GNU/Linux 12 pi ttyAMA10\r\n\r\npi login: \r\n", "login shell"),
        (b"\r\nPassword: \r\nLogin incorrect\r\npi login: \r\n", "login shell"),
        (b"\r\n$GPRMC,123519,A*6A\r\n", "no Build HAT"),
        (b"\xff\xfe\x80\r\n" * 3, "no Build HAT"),
        (b"P0C0: +1 +2 +3\r\nFirware versi\r\n", "another program"),
        (b"\r\nError\r\n", "another program"),
    ],
)
def test_what_answers_instead_of_the_board_is_named(said, cure):
    rig = Rig()
    rig.on_the_way_in = lambda data: said
    rig.begin()
    rig.run(4.5)
    assert cure in rig.start.trouble


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


def test_a_port_that_was_not_heard_is_listed_again():
    rig = Rig()
    rig.on_the_way_in = lambda data: data.replace(b"no ", b"yes ") if rig.board.now < 1 else data
    rig.begin()
    assert rig.until(rig.ready, 3) > 1


def test_ports_that_are_never_heard_are_told_as_such():
    rig = Rig()
    rig.on_the_way_in = lambda data: data.replace(b"no ", b"yes ")
    rig.begin()
    rig.until(lambda: rig.start.trouble, 5)
    assert "another program reads" in rig.start.trouble
    rig.run(5)
    assert "another program reads" in rig.start.trouble
    rig.on_the_way_in = lambda data: data
    rig.until(rig.ready, 5)
    assert rig.start.trouble is None


def test_a_firmware_whose_start_was_not_heard_is_asked():
    rig = Rig(warm=False)
    deaf = {None: (b"D", b"x")}
    rig.on_the_way_in = lambda data: data.replace(*deaf.get(rig.start.version, (b"", b"")))
    rig.begin()
    assert 5 < rig.until(rig.ready, 30) < 12
    assert rig.start.trouble is None


@pytest.mark.parametrize("warm", [True, False])
@pytest.mark.parametrize("garble", [0.002, 0.02])
def test_a_noisy_wire_only_takes_longer(warm, garble):
    rig = Rig(warm=warm)
    rig.board.garble = garble
    rig.begin()
    rig.until(rig.ready, 120)


EVENTS = [
    ev.Answered(),
    ev.CommandError(),
    ev.FirmwareVersion(EXPECTED_VERSION, "x"),
    ev.FirmwareVersion(1, "x"),
    ev.InitDone(),
    ev.Unknown(b"login: "),
    ev.Echo("clear"),
    *(ev.NoDevice(port) for port in range(4)),
    ev.Connected(0, 0x30, False),
    boot.BootloaderVersion(1, "x"),
    boot.BootloaderPrompt(),
    boot.ChecksumOk(),
    boot.SignatureReceived(),
    boot.UploadTimeout(),
    boot.VerificationFailed(),
]


@given(
    st.lists(
        st.tuples(
            st.lists(st.sampled_from(EVENTS), max_size=5), st.sampled_from([0.01, 0.4, 3, 12])
        )
    )
)
def test_whatever_is_heard_in_any_order_the_start_goes_on(story):
    start, now = BringUp(lambda: IMAGE), 0.0
    start.begin(now)
    for heard, passing in story:
        assert isinstance(start.receive(heard, now), bytes)
        now += passing
        assert isinstance(start.tick(now), bytes)
        assert start.ready == (start.stage is Stage.RUNNING)
        if start.wants_reset:
            assert start.stage is Stage.RESETTING
            start.was_reset(now)
    # Nothing said any more: it still ends in a question.
    asked = b""
    for _ in range(10_000):
        if start.ready or b"version" in asked:
            break
        now += 0.05
        asked = start.tick(now)
    assert start.ready or b"version\r" in asked
