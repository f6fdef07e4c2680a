"""``brickpose``: the program's command line.

Only the options of the command that is typed are made, so that help and a wrong argument are quick.
"""

from __future__ import annotations

import argparse
import gc
import logging
import sys
import tomllib
from collections.abc import Sequence
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path

from app.command_parser import CommandParser
from app.feature import Late, Subcommand
from app.feature_search import Features, find_features, named
from app.interruption import Interrupted
from app.languages.catalogue import spoken
from app.operating_system import share_freed_memory
from robot.errors import BrickPoseError

SUBCOMMANDS = (
    Subcommand("run", "serve the dashboard with one robot", Late("app.page.run_options:add_run")),
    Subcommand(
        "doctor",
        "check this machine, or a real robot, and say what to do",
        Late("app.tools.options:add_doctor"),
    ),
    Subcommand(
        "bench", "measure, side by side with peers", Late("app.tools.bench_options:add_bench")
    ),
)
"""The commands that need no feature."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; return 0 on success, 2 on a wrong argument, 1 on any other failure.

    After Ctrl-C it is 130, after SIGTERM 143; but 0 where a signal is the usual end: of servers.
    """
    logging.basicConfig(level=logging.WARNING, format="%(levelname)s %(name)s: %(message)s")
    try:
        parsed = parse(arguments)
        if not gc.isenabled():
            gc.freeze()
            gc.enable()
        share_freed_memory()
        if parsed.features.left_out:  # else whatever is asked first finds all of them
            Late("app.engine.plugging:plug_in")(parsed.features)
        return int(parsed.command(parsed))
    except BrickPoseError as error:
        return _complain(error, error.exit_code)
    except OSError as error:
        return _complain(error, 1)
    except Interrupted as interrupted:
        return interrupted.code


def parse(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    """Parse what was typed; its ``features`` are those that take part, ``command`` carries it out.

    Raises:
        SettingError: a feature is to be left out that does not exist.
        SystemExit: any other argument is wrong, or help was asked for.
    """
    features = find_features(_left_out(arguments), (each.name for each in SUBCOMMANDS))
    parsed = _parser(features).parse_args(arguments)
    vars(parsed).pop("without", None)
    parsed.features = features
    return parsed


def _left_out(arguments: Sequence[str] | None) -> list[str]:
    """Return the names of the features to leave out: they may take commands away."""
    early = CommandParser("brickpose", add_help=False)
    early.add_argument("--config", type=Path, nargs="?")
    given = vars(early.parse_known_args(arguments)[0])
    names: list[str] = given.get("without", [])
    # What is wrong with the option or its file is told by the command that reads it.
    with suppress(OSError, ValueError, KeyError, TypeError, AttributeError):
        table = tomllib.loads(given["config"].read_text(encoding="utf-8"))
        names = [*names, *map(str, table["features"]["without"])]
    return names


def _parser(features: Features) -> CommandParser:
    parser = CommandParser(
        prog="brickpose",
        description="A LEGO robot that localizes itself on taped floors.",
    )
    parser.add_argument("--version", action="version", version=f"brickpose {version('brickpose')}")
    left_out = (f"without {name}" for name in features.left_out)
    parser.remark = "; ".join((*left_out, *features.failures))
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    fills = [(each, each.options) for each in SUBCOMMANDS]
    for feature in features.active:
        fills += [(each, named(feature, each.options)) for each in feature.subcommands]
    for each, fill in fills:
        commands.add_parser(each.name, help=each.about, fill=fill).features = features
    return parser


def _complain(error: Exception, code: int) -> int:
    text = str(error) or type(error).__name__
    if isinstance(error, OSError) and error.strerror and error.filename:
        text = f"{error.filename}: {error.strerror}"
    sys.stderr.write(f"brickpose: {spoken().translated(text)}\n")
    return code
