"""What the Build HAT says is understood, and garbage stays where it is."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot.hat.protocol import events as ev
from robot.hat.protocol.decoder import LONGEST, Decoder

BLOCK = """type 4C
  nmodes =5
  nview  =3
  baud   =115200
  hwver  =00000004
  swver  =10000000
  M0 POWER SI = PCT
    format count=1 type=0 chars=4 dp=0
    RAW: 00000000 00000064    PCT: 00000000 00000064    SI: 00000000 00000064
  M1 COL O SI =\x20
  C0: M1+M2+M3
     speed PID: 00000BB8 00000064 00002328 00000438
  position PID: 00002EE0 000003E8 00013880 00000000"""
DUMP = (" Port 4D 4E 4F", "   0  BA 2C 8A", "   3  AA 2C 8A")
BANNER = (
    "Type help <RETURN> for help",
    "Initialising ports",
    "Resetting drivers: 0123",
    "Reading driver dumps: before port_initdriver(): 0123",
    "set baud rate to 115200",
    "Verifying image...",
    "Verifying image length=51456 00 00 1F 2E",
    "SHA256:",
    "Public key:",
    " ".join(["A0"] * 32),
    " ".join(["0f"] * 64),
)
REFUSED = (
    "Image too large (maximum 245760 bytes)",
    "Incorrect signature length (should be64 bytes)",
    "No image loaded",
)

LINES = [
    ("", ev.Answered()),
    ("Error", ev.CommandRefused()),
    (
        "Firmware version: 1737564117 2025-01-22T16:41:57+00:00",
        ev.FirmwareVersion(1737564117, "2025-01-22T16:41:57+00:00"),
    ),
    (
        "BuildHAT bootloader version 1631704133 2021-09-15T12:08:53+01:00",
        ev.BootloaderVersion(1631704133, "2021-09-15T12:08:53+01:00"),
    ),
    ("Firmware signature:" + " 0A" * 64, ev.Notice("Firmware signature:" + " 0A" * 64)),
    ("P0: connecting to active device", ev.Notice("P0: connecting to active device")),
    ("P0: connected to active ID 4C", ev.Connected(0, 0x4C, False)),
    ("P2: connected to passive ID 10", ev.Connected(2, 10, True)),
    ("P3: established serial communication with active ID 31", ev.Established(3, 0x31)),
    ("P1: no device detected", ev.NoDevice(1)),
    ("P1: disconnected", ev.Disconnected(1)),
    (
        "P1: timeout during data phase: disconnecting",
        ev.ConnectionFailed(1, "timeout during data phase"),
    ),
    (
        "P1: timeout during setup phase: disconnecting",
        ev.ConnectionFailed(1, "timeout during setup phase"),
    ),
    ("P1: framing error: disconnecting", ev.ConnectionFailed(1, "framing error")),
    ("P1: checksum error: disconnecting", ev.ConnectionFailed(1, "checksum error")),
    ("P1: too many errors (3+4): disconnecting", ev.ConnectionFailed(1, "too many errors (3+4)")),
    ("P0: button pressed", ev.Notice("P0: button pressed")),
    ("P0: button released", ev.Notice("P0: button released")),
    ("P0: pulse done", ev.Notice("P0: pulse done")),
    ("P3: ramp done", ev.Notice("P3: ramp done")),
    ("P0M2: +269", ev.Notice("P0M2: +269")),
    ("P0M12: -1 +2", ev.Notice("P0M12: -1 +2")),
    ("P0M3:  0.00000 -1.23456E-5", ev.Notice("P0M3:  0.00000 -1.23456E-5")),
    ("P0C0: +47 +246 -114", ev.CombiData(0, 0, (47, 246, -114))),
    ("P0C0:  0 +12 -7", ev.CombiData(0, 0, (0, 12, -7))),
    ("P1C3:  0  0  0", ev.CombiData(1, 3, (0, 0, 0))),
    ("P1C0: +10 -2147483648 +179", ev.CombiData(1, 0, (10, -(2**31), 179))),
    ("P0V: -91.0000", ev.Notice("P0V: -91.0000")),
    ("P0V:  91.0000", ev.Notice("P0V:  91.0000")),
    ("P0V: 1.00000E9", ev.Notice("P0V: 1.00000E9")),
    ("P0V: -Inf", ev.Notice("P0V: -Inf")),
    ("7.98 V", ev.SupplyVoltage(7.98)),
    ("10.10 V", ev.SupplyVoltage(10.1)),
    ("Motor power fault", ev.MotorPowerFault()),
    ("Port power fault", ev.PortPowerFault()),
    *((text, ev.Notice(text)) for text in DUMP),
    ("deltat=00000013", ev.Notice("deltat=00000013")),
    ("MQ overrun!", ev.Notice("MQ overrun!")),
    ("Attempting reset of I²C bus", ev.Notice("Attempting reset of I²C bus")),
    ("Done initialising ports", ev.InitDone()),
    *((text, ev.Notice(text)) for text in BANNER),
    *((text, ev.Notice(text)) for text in BLOCK.splitlines()),
    ("Image received", ev.Notice("Image received")),
    ("Checksum OK", ev.ChecksumOk()),
    ("Checksum failure", ev.ChecksumFailure()),
    ("Signature received", ev.SignatureReceived()),
    ("Timed out waiting for data", ev.UploadTimeout()),
    *((text, ev.UploadRefused(text)) for text in REFUSED),
    ("Image verifed OK", ev.Notice("Image verifed OK")),
    ("Image verification failed", ev.VerificationFailed()),
    ("Rebooting...", ev.Notice("Rebooting...")),
]
ALL = b"".join(text.encode() + b"\r\n" for text, _ in LINES)
MEANT = [event for _, event in LINES]


@pytest.mark.parametrize(("text", "event"), LINES)
def test_each_line_has_its_meaning(text, event):
    assert Decoder().feed(text.encode() + b"\r\n") == [event]


def test_every_kind_of_event_is_in_the_list_of_lines():
    glued = {ev.BootloaderPrompt, ev.Echo, ev.UnknownLine}
    assert {type(event) for event in MEANT} | glued == set(ev.Event.__args__)


@given(st.lists(st.integers(0, len(ALL)), max_size=30))
def test_pieces_make_no_difference(cuts):
    decoder, events, at = Decoder(), [], 0
    for cut in [*sorted(cuts), len(ALL)]:
        events += decoder.feed(ALL[at:cut])
        at = cut
    assert events == MEANT


def test_byte_by_byte_makes_no_difference():
    decoder = Decoder()
    assert [event for byte in ALL for event in decoder.feed(bytes([byte]))] == MEANT


@pytest.mark.parametrize("end", [b"\r", b"\n", b"\r\n"])
def test_half_an_end_of_line_ends_the_line(end):
    said = b"P0: pulse done" + end + b"P1C0: +1 +2 +3" + end
    assert Decoder().feed(said) == [ev.Notice("P0: pulse done"), ev.CombiData(1, 0, (1, 2, 3))]


@pytest.mark.parametrize(
    "text",
    [
        "P0C0: +1 +2\0 -3",
        "P0C0: 1 +2 -3",
        "P0C0: +1 +02 -3",
        "P0C0: +1  +2 -3",
        "P0C0: +1 + -3",
        "P0C0:",
        "P0C0: ",
        "P0C0",
        "P4C0: +1",
        "P0C0: ٣",
        "P0C0: +1 +99999999999",
        "P:",
        "P",
        ":",
        "100.00 V",
        "1.5 V",
        "raspberrypi login: ",
        "P0: pulse don",
        "deltat=1",
        "Firmware version: 1 ",
        "Firmware version: x y",
        "A0 " * 32 + "x",
        "P0C0:" + "  0" * 150 + " x",
    ],
)
def test_a_garbled_line_is_unknown_and_not_believed(text):
    raw = text.encode()
    assert Decoder().feed(raw + b"\r\n") == [ev.UnknownLine(raw)]


def test_a_break_on_the_wire_before_a_line_costs_nothing():
    assert Decoder().feed(b"\0\0P0: pulse done\r\n") == [ev.Notice("P0: pulse done")]


def test_the_bootloaders_prompt_is_seen_before_its_line_ends():
    decoder = Decoder()
    assert decoder.feed(b"\r\nBHBL>") == [ev.Answered()]
    assert decoder.feed(b" ") == [ev.BootloaderPrompt()]
    assert decoder.feed(b"clear") == []
    assert decoder.feed(b"\r\nBHBL> ") == [ev.Echo("clear"), ev.BootloaderPrompt()]
    assert decoder.feed(b"\r\nImage received\r\n") == [ev.Echo(""), ev.Notice("Image received")]


def test_the_bootloaders_answers_are_told_from_its_echo():
    said = b"BHBL> version\r\nBuildHAT bootloader version 1631704133 2021-09-15\r\nBHBL> "
    assert Decoder().feed(said) == [
        ev.BootloaderPrompt(),
        ev.Echo("version"),
        ev.BootloaderVersion(1631704133, "2021-09-15"),
        ev.BootloaderPrompt(),
    ]


def test_a_prompt_after_a_cut_line_is_still_seen():
    assert Decoder().feed(b"P0C0: +1 +BHBL> ") == [
        ev.UnknownLine(b"P0C0: +1 +"),
        ev.BootloaderPrompt(),
    ]


def test_the_firmwares_prompt_hides_nothing():
    said = b"P0>P0C0: +1 +2 +3\r\nP1>port 0\r\nP0>7.98 V\r\n"
    assert Decoder().feed(said) == [
        ev.CombiData(0, 0, (1, 2, 3)),
        ev.Echo("port 0"),
        ev.SupplyVoltage(7.98),
    ]


def test_an_error_of_the_inner_bus_hides_nothing():
    said = "<I²C bus timeout><generic I²C bus error>P0: pulse done\r\n<P0: I²C bus timeout>\r\n"
    assert Decoder().feed(said.encode()) == [
        ev.Notice("<I²C bus timeout>"),
        ev.Notice("<generic I²C bus error>"),
        ev.Notice("P0: pulse done"),
        ev.Notice("<P0: I²C bus timeout>"),
        ev.Answered(),
    ]


@pytest.mark.parametrize("step", [1_000_000, 1000])
def test_a_line_of_a_megabyte_is_one_unknown_line_and_is_not_kept(step):
    decoder = Decoder()
    huge = b"P0C0: +1" * 125_000
    events = [e for at in range(0, len(huge), step) for e in decoder.feed(huge[at : at + step])]
    events += decoder.feed(b"\r\nP0: pulse done\r\n")
    assert events == [ev.UnknownLine(huge[: len(events[0].raw)]), ev.Notice("P0: pulse done")]
    assert len(events[0].raw) == LONGEST


@given(st.lists(st.binary(max_size=40)), st.integers(0, 3))
def test_any_bytes_are_taken_and_cost_one_line_at_most(pieces, port):
    decoder = Decoder()
    for piece in pieces:
        assert all(isinstance(event, ev.Event) for event in decoder.feed(piece))
    decoder.feed(b"\r\n")
    assert decoder.feed(b"P%d: pulse done\r\n" % port) == [ev.Notice(f"P{port}: pulse done")]


def wounded(kind, at, byte):
    if kind == "lost":
        return ALL[:at] + ALL[at + 1 :]
    if kind == "doubled":
        return ALL[: at + 1] + ALL[at:]
    return ALL[:at] + bytes([byte]) + ALL[at + 1 :]


@given(
    st.sampled_from(["lost", "doubled", "changed"]),
    st.integers(0, len(ALL) - 1),
    st.integers(0, 255),
)
def test_a_wounded_byte_costs_its_line_and_at_most_the_next(kind, at, byte):
    """A changed end of line glues two lines together; all others are whole."""
    events = Decoder().feed(wounded(kind, at, byte))
    line = ALL[:at].count(b"\n")
    assert events[:line] == MEANT[:line]
    after = MEANT[line + 2 :]
    assert events[len(events) - len(after) :] == after
    assert abs(len(events) - len(MEANT)) <= 2
