"""``brickpose tape-seen``: asks a running program."""

import argparse
import json
from urllib.request import urlopen

from app.command_parser import CommandParser
from app.console import say


def add_options(parser: CommandParser) -> None:
    """Add the options, and say what carries the command out."""
    parser.add_argument(
        "address", nargs="?", default="http://127.0.0.1:8080", help="of the page (%(default)s)"
    )
    parser.set_defaults(command=tape_seen)


def tape_seen(parsed: argparse.Namespace) -> int:
    """Print the answer. A program that does not answer is an OSError, which ends in a line."""
    with urlopen(f"{parsed.address}/api/tape_seen", timeout=10) as answer:
        seen = json.load(answer)
    say(f"{seen['tape']} of {seen['rays']} rays meet tape")
    return 0
