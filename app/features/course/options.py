"""Options of the course's commands."""

from __future__ import annotations

import argparse
from pathlib import Path

from app.command_parser import CommandParser
from app.features.lab.evaluate_options import add_workers
from app.interruption import interruptible
from app.options import config_from
from app.page.run_options import add_serving


def add_check(command: CommandParser) -> None:
    """Add the options of ``check``."""
    command.description = (
        "Run the checks of the lessons on a file, in a process that can harm nothing. "
        "It ends with 0 if all that was begun passed."
    )
    command.add_argument(
        "files",
        type=Path,
        nargs="+",
        metavar="FILE.py",
        help="the student's file; several, or a folder, are those of a class",
    )
    command.add_argument("--lesson", type=int, metavar="N", help="only this one (default: all)")
    command.add_argument("--json", action="store_true", help="findings as JSON, to the terminal")
    command.add_argument("--junit", type=Path, metavar="FILE.xml", help="write JUnit's XML too")
    command.add_argument(
        "--gradescope", type=Path, metavar="FILE.json", help="write Gradescope's results.json too"
    )
    command.add_argument(
        "--csv", type=Path, metavar="FILE.csv", help="of a class, write a row a file too"
    )
    add_workers(command)
    command.add_argument("--seed", type=int, metavar="N", help="seed of the cases, for a teacher")
    add_lessons(command)
    command.set_defaults(command=_check)


def add_learn(command: CommandParser) -> None:
    """Add the options of ``learn``."""
    command.description = (
        "Serve the dashboard with a lesson beside it. The student's file is checked at each save."
    )
    command.formatter_class = argparse.ArgumentDefaultsHelpFormatter
    command.add_argument(
        "lesson", nargs="?", type=int, default=1, metavar="N", help="the lesson to open"
    )
    command.add_argument(
        "--file",
        type=Path,
        default=Path("my_filter.py"),
        metavar="FILE.py",
        help="the student's file; begun if it is not there",
    )
    add_lessons(command)
    add_serving(command)
    command.set_defaults(command=_learn)


def add_lessons(command: argparse.ArgumentParser) -> None:
    """Add the options for a teacher's own lessons and for the language."""
    command.add_argument(
        "--lessons", type=Path, metavar="DIR", help="lessons of your own (docs/course.md)"
    )
    command.add_argument(
        "--language", metavar="CODE", help="en or de (default: as the environment asks)"
    )


def _learn(parsed: argparse.Namespace) -> int:
    config = config_from(parsed)
    # Imported here, so that a wrong argument is refused at once.
    from app.features.course.learn_command import learn  # noqa: PLC0415

    return learn(parsed, config)


def _check(parsed: argparse.Namespace) -> int:
    # Imported here, so that other commands start without it.
    from app.features.course.check_command import check  # noqa: PLC0415

    with interruptible():
        return check(parsed)
