"""The start of a Build HAT whose firmware runs, and of what is none; over the emulated board."""

import pytest
from bring_up_rig import IMAGE, PROGRAM, Rig
from hypothesis import given
from hypothesis import strategies as st

from robot.hat.protocol import events as ev
from robot.hat.start.bring_up import BringUp
from robot.hat.start.firmware_image import EXPECTED_VERSION
from robot.hat.start.upload import Stage


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


def test_reports_and_echo_of_another_program_end():
    rig = Rig()
    rig.board.receive(PROGRAM + b"echo 1\r")
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


@pytest.mark.parametrize("warm", [True, False])
@pytest.mark.parametrize("garble", [0.002, 0.02])
def test_a_noisy_wire_only_takes_longer(warm, garble):
    rig = Rig(warm=warm)
    rig.board.garble = garble
    rig.begin()
    rig.until(rig.ready, 120)


EVENTS = [
    ev.Answered(),
    ev.CommandRefused(),
    ev.FirmwareVersion(EXPECTED_VERSION, "x"),
    ev.FirmwareVersion(1, "x"),
    ev.InitDone(),
    ev.UnknownLine(b"login: "),
    ev.Echo("clear"),
    *(ev.NoDevice(port) for port in range(4)),
    ev.Connected(0, 0x30, False),
    ev.BootloaderVersion(1, "x"),
    ev.BootloaderPrompt(),
    ev.ChecksumOk(),
    ev.SignatureReceived(),
    ev.UploadTimeout(),
    ev.VerificationFailed(),
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
