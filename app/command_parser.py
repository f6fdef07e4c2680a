"""The parser of the command line and of each command; a command's options are added if it is typed.

This module imports little: it is what ``brickpose --help`` needs.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from typing import Any, NoReturn

NO_OPTIONS = ("command", "features")
"""What a parsed command line holds besides options: what carries it out, and ``Features``."""


class CommandParser(argparse.ArgumentParser):
    """Options are not abbreviated, and one that is not given has no value, not even None.

    So a setting in a file is overridden only by what was typed. Subcommands inherit this, and each
    takes ``--without``, which is obeyed before options are parsed: it may take commands away.
    """

    def __init__(
        self, *args: Any, fill: Callable[[CommandParser], None] | None = None, **kwargs: Any
    ) -> None:
        """Make a parser; ``fill`` adds its options when it is the one that parses."""
        usual: dict[str, Any] = {"argument_default": argparse.SUPPRESS, "allow_abbrev": False}
        super().__init__(*args, **(usual | kwargs))
        self._fill = fill
        self.features: Any = None
        """The ``Features`` that take part, for commands that have options of theirs."""
        self.remark = ""
        """What an error says besides, as which commands are left out."""
        self.add_argument(
            "--without",
            metavar="NAME",
            action="append",
            default=argparse.SUPPRESS,
            help="leave out a feature, as lab; may be given more than once (docs/extending.md)",
        )

    def error(self, message: str) -> NoReturn:
        """Say what is wrong with an argument, and end with 2."""
        super().error(f"{message}{self.remark and '; '}{self.remark}")

    def parse_known_args(  # type: ignore[override]
        self, args: Sequence[str] | None = None, namespace: argparse.Namespace | None = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """Parse as usual, after the options were added."""
        if self._fill is not None:
            fill, self._fill = self._fill, None
            fill(self)
        return super().parse_known_args(args, namespace)
