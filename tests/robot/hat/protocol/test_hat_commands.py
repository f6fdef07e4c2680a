"""What is sent to the Build HAT is what its firmware reads by the rules of its language."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot.errors import CommandError
from robot.hat.protocol import commands

WORDS = """
help ? clear_faults port list ledmode pwm coast pid pid_diff set off on vin pwmparams plimit
port_plimit select selonce selrate combi write1 write2 echo debug version signature
"""
NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)")
BYTES_A_SECOND = 11520

ports = st.integers(0, 3)
parts = st.floats(0, 1)
duties = st.dictionaries(ports, st.floats(-1, 1), min_size=1)


def read(sent):
    """Commands with their arguments, numbers as floats, as the firmware takes a line apart."""
    assert len(sent) <= 256
    assert sent.endswith(b"\r")
    assert sent.count(b"\r") == 1
    text = sent[:-1].decode("ascii")
    assert text.isprintable()
    read = []
    for word in re.split("[ ;]+", text):
        if NUMBER.fullmatch(word):
            read[-1].append(float(word))
        elif word == "pulse":
            read[-1].append(word)
        else:
            # The first command that begins like this is the one that runs.
            read.append([next(known for known in WORDS.split() if known.startswith(word))])
    return read


@given(duties, st.floats(0.02, 2))
def test_pulses_drive_each_port_for_a_time_and_end_at_zero(wanted, seconds):
    done = read(commands.pulses(wanted, seconds))
    assert [c[1] for c in done[::2]] == list(wanted)
    assert {c[0] for c in done[::2]} == {"port"}
    for duty, to in zip(wanted.values(), done[1::2], strict=True):
        assert to[:2] == ["set", "pulse"]
        assert to[2] == pytest.approx(duty, abs=5e-4)
        assert to[3] == to[5] == 0
        assert to[4] == pytest.approx(seconds, abs=5e-4)


@given(st.floats(-1, 1), st.floats(-1, 1))
def test_two_motors_a_hundred_times_a_second_are_under_half_of_the_link(left, right):
    sent = commands.pulses({2: left, 3: right}, 0.25)
    assert 100 * len(sent) < 0.5 * BYTES_A_SECOND


def test_pulses_are_as_short_as_the_language_allows():
    sent = commands.pulses({0: 0.512, 1: -0.4}, 0.2)
    assert sent == b"p 0;s pulse .512 0 .2 0;p 1;s pulse -.4 0 .2 0\r"


@given(ports, st.integers(0, 10**9), parts)
def test_a_motor_stands_before_its_limit_is_lifted_and_its_period_comes_last(port, period, limit):
    done = read(commands.set_up_motor(port, period, limit))
    words = "port pwm off port_plimit pwmparams combi select selrate"
    assert " ".join(c[0] for c in done) == words
    assert done[0] == ["port", port]
    assert done[3][1] == pytest.approx(limit, abs=5e-4)
    assert done[4][1:] == [0, 0]
    assert done[5:] == [["combi", 0, 1, 0, 2, 0, 3, 0], ["select", 0], ["selrate", period]]


@given(st.sets(ports, min_size=1))
def test_a_stop_leaves_closed_loops_and_old_set_points_behind_in_one_line(which):
    done = read(commands.stop(which))
    assert done == [c for port in which for c in (["port", port], ["pwm"], ["off"])]


def test_a_stop_is_for_all_ports_unless_told_otherwise():
    assert [c[1] for c in read(commands.stop()) if c[0] == "port"] == [0, 1, 2, 3]


def test_quiet_ends_reports_traces_and_echo_of_all_ports():
    selects = [c for port in range(4) for c in (["port", port], ["select"])]
    assert read(commands.silence()) == [*selects, ["echo", 0], ["debug", 0]]


@pytest.mark.parametrize(
    ("sent", "expected"),
    [
        (commands.version(), b"version\r"),
        (commands.devices(), b"list\r"),
        (commands.supply(), b"vin\r"),
        (commands.clear_faults(), b"clear_faults\r"),
        (commands.clear(), b"clear\r"),
        (commands.load(51456, 495305442), b"load 51456 495305442\r"),
        (commands.signature(64), b"signature 64\r"),
        (commands.payload(b"a\r\nb"), b"\x02a\r\nb\x03\r"),
        (commands.reboot(), b"reboot\r"),
        (commands.line(), b"\r"),
        (commands.line("port 0", "vin"), b"port 0;vin\r"),
    ],
)
def test_plain_commands(sent, expected):
    assert sent == expected


@given(st.floats(allow_nan=False, allow_infinity=False, width=32), st.integers(0, 6))
def test_numbers_are_read_back_and_have_no_exponent(value, places):
    text = commands.fixed(value, places)
    assert NUMBER.fullmatch(text)
    assert float(text) == pytest.approx(value, abs=0.5000001 * 10**-places, rel=1e-15)


@pytest.mark.parametrize(
    ("value", "text"),
    [(0, "0"), (-1e-9, "0"), (0.5, ".5"), (-0.25, "-.25"), (20, "20"), (1e-5, "0"), (100.0, "100")],
)
def test_numbers_are_short(value, text):
    assert commands.fixed(value, 3) == text


def test_whole_numbers_keep_their_zeros():
    assert commands.fixed(1200, 0) == "1200"


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf")])
def test_what_is_no_number_is_refused(value):
    with pytest.raises(CommandError, match="finite"):
        commands.fixed(value, 3)


@pytest.mark.parametrize(
    "part", ["vin\r", "vin\n", "set\t1", "set 1e-05", "set -2.5E3", "port 0;set .1e2", "sét", "\0"]
)
def test_what_would_poison_the_line_is_refused(part):
    with pytest.raises(CommandError, match="valid"):
        commands.line("port 0", part)


def test_a_line_that_would_be_cut_is_refused():
    assert len(commands.line("#" * 255)) == 256
    with pytest.raises(CommandError, match="256"):
        commands.line("#" * 256)


@pytest.mark.parametrize("port", [-1, 4])
def test_a_port_that_is_none_is_refused(port):
    for build in (
        lambda: commands.stop([port]),
        lambda: commands.pulses({port: 0.5}, 0.2),
        lambda: commands.set_up_motor(port, 10, 1.0),
    ):
        with pytest.raises(CommandError, match="0 to 3"):
            build()
