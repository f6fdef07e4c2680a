"""Messages that are built as their formats want it, with values that may be anything."""

from __future__ import annotations

import json
import math

import cbor2
from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy
from parsers import CONTENT

SCALARS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=5),
    st.sampled_from([10**400, -(2**63), 2**31, 1e308, math.nan, math.inf, "\n", "x" * 300, ""]),
)
VALUES = st.recursive(
    SCALARS,
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner, max_size=4)
    ),
    max_leaves=12,
)


def objects(**known: SearchStrategy[object]) -> SearchStrategy[dict[str, object]]:
    """JSON objects with some of these fields, and sometimes an unknown one."""
    return st.builds(
        lambda fields, more: {**fields, **more},
        st.fixed_dictionaries({}, optional=dict(known)),
        st.dictionaries(st.text(max_size=4), VALUES, max_size=1),
    )


def as_json(values: SearchStrategy[object]) -> SearchStrategy[bytes]:
    """The values as JSON; NaN and infinities as Python writes them."""
    return values.map(lambda value: json.dumps(value).encode())


REAL = st.floats(-1.2, 1.2) | SCALARS
COMMANDS = {
    "drive": objects(v=REAL, omega=REAL),
    "set_pose": objects(
        x=REAL, y=REAL, theta=REAL, sd_xy=REAL, sd_theta=REAL,
        covariance=st.lists(REAL, min_size=9, max_size=9) | VALUES,
    ),
    "set_particles": objects(
        poses=st.lists(st.lists(REAL, min_size=3, max_size=3), max_size=4) | VALUES,
        weights=st.lists(REAL, max_size=4) | VALUES,
    ),
    "set_parameters": objects(
        values=st.dictionaries(
            st.sampled_from(["alpha1", "sigma_hit", "max_particles", "laser_model_type", "é\n"])
            | st.text(max_size=5),
            VALUES,
            max_size=3,
        )
    ),
    "place": objects(x=REAL, y=REAL, theta=REAL),
    "show": objects(layer=st.sampled_from(["scan", "cloud"]) | VALUES, visible=VALUES),
    "replay": objects(paused=VALUES, speed=REAL, position_s=REAL, step=VALUES),
    "record": objects(on=VALUES),
    **{name: objects() for name in ("stop", "take", "scatter", "undo", "reset", "ping", "fly")},
}  # fmt: skip
LIVE = as_json(
    st.sampled_from(sorted(COMMANDS)).flatmap(
        lambda kind: COMMANDS[kind].map(lambda rest: {"type": kind, "id": 1, **rest})
    )
    | VALUES
)

TWIST = {"linear": {"x": 0.1}, "angular": {"z": 0.2}}
POSE = {"pose": {"pose": {"position": {"x": 0.1}, "orientation": {"w": 1.0}}}}
TOPICS = st.sampled_from(["/scan", "/odom", "/cmd_vel", "/initialpose", "rosapi/topics", "/map"])
SERVICES = st.sampled_from(
    ["/set_initial_pose", "/reinitialize_global_localization", "/rosapi/nodes"]
)
MESSAGES = st.sampled_from([TWIST, {"twist": TWIST}, POSE, {"pose": POSE}]) | VALUES
OPERATIONS = st.sampled_from(
    ["subscribe", "unsubscribe", "advertise", "publish", "call_service", "set_level", "fragment",
     "unadvertise", "status", "auth", "fly"]
)  # fmt: skip
REQUESTS = st.fixed_dictionaries(
    {"op": OPERATIONS},
    optional={
        "topic": TOPICS | VALUES,
        "service": SERVICES | VALUES,
        "msg": MESSAGES,
        "args": MESSAGES,
        "compression": st.sampled_from(["none", "cbor", "cbor-raw", "png"]) | VALUES,
        "level": st.sampled_from(["none", "error", "info"]) | VALUES,
        **dict.fromkeys(("type", "id", "throttle_rate", "queue_length", "num", "total"), VALUES),
        "data": VALUES,
    },
)
ROSBRIDGE = st.lists(as_json(REQUESTS | VALUES) | st.binary(max_size=20), max_size=4).map(
    b"\n".join
)

HAT_NUMBERS = st.integers().map(lambda n: f"{n:+d}" if n else " 0") | st.floats().map(str)
HAT_LINES = st.one_of(
    st.builds(
        lambda port, kind, values: f"P{port}{kind}: {' '.join(values)}",
        st.integers(0, 4),
        st.sampled_from(["C0", "C1", "M0", "M12", "V", "C9"]),
        st.lists(HAT_NUMBERS, max_size=5),
    ).map(str.encode),
    st.sampled_from([b"P0: pulse done", b"7.98 V", b"Error", b"BHBL> ", b"P0>", b"", b"deltat="]),
    st.binary(max_size=20),
)
HAT = st.lists(
    st.builds(bytes.__add__, HAT_LINES, st.sampled_from([b"\r\n", b"\r", b"\n", b"\0", b""])),
    max_size=12,
).map(b"".join)

CHANNELS = st.sampled_from(
    [
        (b"/cmd_vel geometry_msgs/msg/TwistStamped", {"twist": TWIST}),
        (b"/initialpose geometry_msgs/msg/PoseWithCovarianceStamped", POSE),
        (b"cmd_vel geometry_msgs/msg/TwistStamped", TWIST),
    ]
)
FOXGLOVE = st.builds(
    lambda channel, encoding, message, own: (
        channel[0] + encoding + CONTENT + json.dumps(channel[1] if own else message).encode()
    ),
    CHANNELS,
    st.sampled_from([b" json", b" json", b" cdr", b" xml", b""]),
    MESSAGES,
    st.booleans(),
)

REMOTE = objects(
    topic=VALUES, msg=objects(secs=VALUES, nsecs=VALUES, bytes=VALUES | st.binary(max_size=9))
).map(cbor2.dumps)

SAVED_POSES = as_json(objects(map=SCALARS, extent=VALUES, hypotheses=VALUES, truth=VALUES))
