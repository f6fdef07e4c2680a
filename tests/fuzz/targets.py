"""The table of what is fuzzed: a parser, inputs of its format, and files that are kept for it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import file_structures as files
import message_structures as messages
import parsers
from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy
from mutations import mutated
from parsers import Parser

CORPUS = Path(__file__).parent / "corpus"
"""A folder a target; files that begin with VALID must be taken, all others refused."""
VALID = "valid"

Inputs = SearchStrategy[bytes]


@dataclass(frozen=True)
class Target:
    """One reader of foreign bytes."""

    parser: Parser
    structured: Inputs | Callable[[Sequence[bytes]], Inputs]
    """Inputs as the format wants them; or a function that makes them of the valid files."""
    words: tuple[bytes, ...] = ()
    """Words that mean something to the reader."""

    def inputs(self, valid: Sequence[bytes], others: Sequence[bytes] = ()) -> Inputs:
        """Inputs of all kinds: built, changed, or any bytes."""
        built, kept = self.structured, [*valid, *others]
        if not isinstance(built, SearchStrategy):
            built = built(valid)
        near = mutated(kept, self.words)
        return st.one_of(near, built, near, built, near, st.binary(max_size=200))


TARGETS = {
    "hat": Target(parsers.hat, messages.HAT, (b"P0C0: +1 +2 +3\r\n", b"BHBL> ", b"P0>", b"\r")),
    "live": Target(parsers.live, messages.LIVE, (b'"type":"drive"', b'"x":', b'"values":')),
    "rosbridge": Target(parsers.rosbridge, messages.ROSBRIDGE, (b'"op":"publish"', b"/cmd_vel")),
    "foxglove": Target(parsers.foxglove, messages.FOXGLOVE, (b"cdr", b"json", b"map")),
    "dds": Target(parsers.dds, messages.FOXGLOVE, (b"map", b"\0\x01\0\0", b"\0\0\0\0")),
    "remote": Target(parsers.remote, messages.REMOTE, (b"\xfb\x7f\xf0" + bytes(6), b"\xc2\x49")),
    "mcap": Target(parsers.RECORDING, files.damaged_recordings),
    "replay": Target(parsers.REPLAY, files.recordings),
    "map_yaml": Target(
        parsers.map_yaml,
        files.yaml_keys(
            "image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh", "mode"
        ),
        (b"mode: raw\n", b"mode: scale\n", b"origin: [1, 2, 3]\n", b"negate: 1\n"),
    ),
    "map_picture": Target(parsers.map_picture, files.PICTURES, (b"P2", b"P6", b"65535")),
    "svg": Target(parsers.DRAWING, files.SVG, (b"<g>", b"</g>", b"stroke", b"M0 0", b"%")),
    "trajectory": Target(parsers.TRAJECTORY, files.tables(), (b"#", b"Frame", b"\n1,")),
    "urdf": Target(parsers.urdf, files.urdf(), (b"<link", b"/>", b"xyz=", b"0 0 0")),
    "lens": Target(
        parsers.LENS_FILE,
        files.yaml_keys(
            "image_width", "image_height", "camera_matrix", "distortion_coefficients",
            "distortion_model", "rolling_shutter_readout",
        ),
    ),
    "settings": Target(parsers.SETTINGS, files.SETTINGS, (b"[sim]", b"[camera]", b"robot =")),
    "replay_settings": Target(parsers.REPLAY_SETTINGS, files.SETTINGS, (b"[localization]",)),
    "sweep": Target(parsers.SWEEP, files.SWEEP, (b"[sweep]", b"sample = 3\n", b"low = 1")),
    "profile": Target(parsers.PROFILE, files.PROFILE, (b"[camera_roll]", b"value =", b"[lens]")),
    "pose": Target(parsers.POSE, messages.SAVED_POSES),
}  # fmt: skip


def kept_files(name: str) -> list[Path]:
    """The kept files of a target, sorted."""
    return sorted((CORPUS / name).iterdir())


def samples(name: str) -> tuple[list[bytes], list[bytes]]:
    """The contents of a target's kept files: those that are valid, and the others."""
    contents: tuple[list[bytes], list[bytes]] = [], []
    for path in kept_files(name):
        contents[not path.name.startswith(VALID)].append(path.read_bytes())
    return contents
