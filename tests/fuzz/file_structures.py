"""Files that are built as their formats want it, with values that may be anything."""

from __future__ import annotations

import io
import json
from collections.abc import Sequence
from xml.etree import ElementTree

from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from mutations import NUMBERS, changed, changes, mutated, pick

from app.settings.config import Config
from app.settings.provenance import settings_of
from robot.description.spec import SPIKE
from robot.description.unknowns import NAMES as UNKNOWN_NAMES
from robot.description.unknowns import ROBOT


def joined(lines: Sequence[str]) -> bytes:
    """Return lines as the bytes of a file."""
    return "\n".join(lines).encode(errors="surrogatepass")


PATHS = sorted(settings_of(Config()))
TOML_VALUES = st.one_of(
    st.sampled_from([number.decode() for number in NUMBERS]),
    st.sampled_from(["true", '"auto"', '"likelihood_field"', "{}", "[[1, 2], []]", "07:32:00"]),
    st.integers().map(str),
    st.floats().map(repr),
    st.text(max_size=8).map(json.dumps),
    st.lists(st.floats().map(repr) | st.text(max_size=3).map(json.dumps), max_size=3).map(
        lambda items: f"[{', '.join(items)}]"
    ),
)
TOML_NAMES = st.sampled_from([*PATHS, *{path.rpartition(".")[0] or "sim" for path in PATHS}])
TOML_LINES = st.builds(
    "{} = {}".format, TOML_NAMES | st.text(max_size=4).map(json.dumps), TOML_VALUES
)
SETTINGS = st.lists(TOML_LINES, max_size=3).map(joined)
SWEEP_LINES = st.builds(
    "{} = {}".format,
    st.sampled_from(["seeds", "laps", "worlds", "offset", "sample", "conditions", "first_seed"]),
    TOML_VALUES | st.sampled_from(['["sim"]', "[0, 0, 0.1]", '["default", "late"]']),
)
PROFILE_LINES = st.one_of(
    st.builds(
        "{} = {}".format,
        st.sampled_from(["robot", "made", "source", "value", "sd", "width", "model"]),
        TOML_VALUES | st.sampled_from(['"spike"', "2026-01-02T03:04:05Z", "0.01"]),
    ),
    st.builds("[{}]".format, st.sampled_from([*UNKNOWN_NAMES[:ROBOT], "lens"])),
)
PROFILE = st.lists(PROFILE_LINES, max_size=8).map(joined)
CHOICES = st.one_of(
    st.lists(TOML_VALUES, max_size=3).map(lambda items: f"[{', '.join(items)}]"),
    st.builds("{{ low = {}, high = {} }}".format, TOML_VALUES, TOML_VALUES),
)
SWEEP = st.builds(
    lambda head, lines: joined(["[sweep]", *head, "[settings]", *lines]),
    st.lists(SWEEP_LINES, max_size=2),
    st.lists(st.builds("{} = {}".format, TOML_NAMES, CHOICES | TOML_VALUES), max_size=3),
)

WORDS = st.sampled_from(
    ["M", "0", "10", "-5", "1e9", "1e999", "nan", "C", "A", "Z", "h", "%", "mm", "none", "black",
     "(", ")", "rotate(", "scale(", "#12", "#123456", "url(#a)", "round", ",", " ", ";", ":", "é",
     "100", "L", "v-50", "matrix(1 0 0 1 0 0)", "1e-9", "a 5 5 0 0 1 9 9", "url(#b)", "#a", "#b",
     "non-scaling-stroke", "0.5", "inherit", "var(--a, 1)", "evenodd", "stroke", "currentColor",
     "objectBoundingBox", "fill:none;", "stroke:#111;", "slice", "a", "b"]
)  # fmt: skip
NAMES = st.sampled_from(
    ["d", "x", "y", "r", "rx", "cx", "width", "height", "points", "transform", "style", "stroke",
     "stroke-width", "stroke-linejoin", "stroke-dasharray", "fill", "fill-rule", "viewBox", "id",
     "class", "href", "stroke-miterlimit", "stroke-opacity", "preserveAspectRatio", "color",
     "opacity", "clip-path", "clip-rule", "clipPathUnits", "vector-effect", "paint-order",
     "overflow", "transform-origin", "requiredExtensions", "mask", "data-tape"]
)  # fmt: skip
TAGS = st.sampled_from(
    ["path", "rect", "circle", "ellipse", "polygon", "polyline", "line", "use", "g", "svg",
     "symbol", "clipPath", "switch", "a", "linearGradient", "stop", "image"]
)  # fmt: skip
SHEETS = st.lists(
    st.sampled_from(
        ["path", "*", ".a", "#b", " ", ">", "+", "~", ",", ":not(", ":is(", ")", ":nth-child(2n)",
         "[id", "=a]", "{", "}", "stroke", ":", "#111", ";", "display:none", "!important",
         "@media screen{", "@import x;", "/*", "*/", "--a:1", "fill:url(#a)", "<![CDATA[", "]]>"]
    ),
    max_size=12,
).map(lambda words: f"<style>{''.join(words)}</style>")  # fmt: skip
FIELDS = st.dictionaries(NAMES, st.lists(WORDS, max_size=8).map(" ".join), max_size=6)
SHAPES = st.recursive(
    SHEETS,
    lambda inner: st.builds(
        lambda tag, fields, content: (
            f"<{tag} {' '.join(f'{n}={v!r}' for n, v in fields.items())}>{''.join(content)}</{tag}>"
        ),
        TAGS,
        FIELDS,
        st.lists(inner, max_size=2),
    ),
    max_leaves=6,
)
SVG = st.lists(SHAPES, max_size=4).map(
    lambda shapes: (
        '<svg xmlns="http://www.w3.org/2000/svg" width="2000" height="1000" '
        f'viewBox="-1000 -500 2000 1000">{"".join(shapes)}'
        '<path d="M0 0h100" stroke="#222" stroke-width="50" fill="none"/></svg>'
    ).encode()
)

URDF_WORDS = st.sampled_from(
    ["", "nan", "inf", "-1", "0", "1e308", "x", "0 0", "0 0 0", "1 1 1", "1e6 1e6 1e6", "a\nb"]
)


@st.composite
def urdf(draw: st.DrawFn) -> bytes:
    """The robot's description with elements missing, doubled or moved, or attributes changed."""
    root = ElementTree.parse(SPIKE).getroot()
    for _ in range(draw(st.integers(1, 3))):
        inner = [(parent, element) for parent in root.iter() for element in parent]
        parent, element = draw(st.sampled_from(inner))
        change = draw(
            st.sampled_from(["remove", "double", "move", "name", *sorted(element.attrib)])
        )
        match change:
            case "remove":
                parent.remove(element)
            case "double":
                parent.append(element)
            case "move":
                draw(st.sampled_from(inner))[0].append(ElementTree.Element(element.tag))
            case _:
                element.set(change, draw(URDF_WORDS))
    return ElementTree.tostring(root)


CELLS = st.one_of(
    st.floats().map(repr),
    st.integers().map(str),
    st.text("0123456789.-+eEinfa_ ٣", max_size=6),
    st.sampled_from(["0", "1", "2", "1e9", "1e308", "1e-320"]),
)
HEADS = st.sampled_from(
    [
        ("", 8),
        ("# Time [s]    x [m]    y [m]    orientation [rad]\n", 4),
        ("# Time [s]    forward velocity [m/s]    angular velocity[rad/s]\n", 3),
        ("stamp x y z qx qy qz qw\n", 8),
        ("#timestamp [ns], p_x [m], p_y [m], p_z [m], q_w [], q_x [], q_y [], q_z []\n", 8),
        ("stamp_ms,x_cm,y,z,qx,qy,qz,qw\n", 8),
        ("time [klingon],x [m],y,z,qx,qy,qz,qw\n", 8),
    ]
)


@st.composite
def tables(draw: st.DrawFn) -> bytes:
    """Rows of numbers below one of the headers, the stamps rising or not."""
    head, columns = draw(HEADS)
    rows = draw(st.lists(st.lists(CELLS, min_size=columns, max_size=columns), max_size=5))
    if draw(st.booleans()):
        rows = [[str(index), *row[1:]] for index, row in enumerate(rows)]
    between = "," if "," in head else " "
    return (head + "\n".join(between.join(row) for row in rows)).encode(errors="surrogatepass")


def yaml_keys(*keys: str) -> SearchStrategy[bytes]:
    """Keys with numbers, lists or words."""
    numbers = st.sampled_from([number.decode() for number in NUMBERS]) | st.floats().map(repr)
    values = st.one_of(
        numbers,
        st.sampled_from(
            ["map.pgm", "trinary", "raw", "scale", "plumb_bob", "yes", "map.yaml", ".."]
        ),
        st.lists(numbers, min_size=1, max_size=9).map(lambda items: f"[{', '.join(items)}]"),
        st.lists(numbers, min_size=9, max_size=9).map(lambda n: f"{{data: [{', '.join(n)}]}}"),
        st.text(max_size=5).map(json.dumps),
    )
    return st.lists(st.builds("{}: {}".format, st.sampled_from(keys), values), max_size=9).map(
        joined
    )


PICTURES = st.builds(
    lambda head, rest: head + rest,
    st.sampled_from(
        [b"P5 ", b"P2 ", b"P6 1 1 255 ", b"P3 ", b"P5 4 3 255\n", b"P5 2 2 65535\n", b"BM",
         b"P2 2 2 255 0 254 ", b"\x89PNG\r\n\x1a\n", b"P5#x\n4 3 254 "]
    ),
    st.binary(max_size=60),
)  # fmt: skip


@st.composite
def recordings(draw: st.DrawFn, kept: Sequence[bytes]) -> bytes:
    """A kept recording written anew, with changes within its messages and attachments.

    Changes of the file itself would be stopped by its checksums.
    """
    reader = make_reader(io.BytesIO(draw(pick(kept))))
    stream = io.BytesIO()
    writer = Writer(stream, compression=draw(st.sampled_from(CompressionType)), enable_crcs=False)
    writer.start("ros2")
    chosen = draw(st.integers(0, 40))
    several = draw(changes((b"[localization]", b"alpha1 = 9", b"/tf")))

    def content(number: int, data: bytes) -> bytes:
        return changed(data, several) if number == chosen else data

    channels: dict[int, int] = {}
    for number, item in enumerate(reader.iter_attachments()):
        writer.add_attachment(0, 0, item.name, item.media_type, content(number, item.data))
    for item in reader.iter_metadata():
        writer.add_metadata(item.name, item.metadata)
    for number, (schema, channel, message) in enumerate(reader.iter_messages(), 8):
        if channel.id not in channels:
            known = writer.register_schema(schema.name, schema.encoding, schema.data)
            channels[channel.id] = writer.register_channel(channel.topic, "cdr", known)
        data = content(number, message.data)
        writer.add_message(channels[channel.id], message.log_time, data, message.publish_time)
    writer.finish()
    return stream.getvalue()


def damaged_recordings(kept: Sequence[bytes]) -> SearchStrategy[bytes]:
    """Kept recordings written anew without checksums, then changed anywhere."""
    return mutated(kept, (b"\x89MCAP0\r\n", b"\x06", b"\x02" + bytes(8)))
