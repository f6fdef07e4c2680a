"""Options of ``brickpose class`` and of ``brickpose single-user``."""

from __future__ import annotations

import argparse
from pathlib import Path

from app.command_parser import CommandParser
from app.features.course.options import add_lessons
from app.options import config_from
from app.page.run_options import add_serving


def add_class(command: CommandParser) -> None:
    """Add the options of ``class``."""
    command.description = (
        "Serve a class by JupyterHub: each student has a robot, and a link that opens it. "
        "Ctrl-C ends all of it; files and links are there again at the next start."
    )
    command.add_argument(
        "students",
        type=Path,
        metavar="STUDENTS.csv",
        help="the students' names: one a line, or a table with a column 'name'",
    )
    command.add_argument(
        "--folder",
        type=Path,
        metavar="DIR",
        help="where the class's files lie (default: STUDENTS.class, beside the list)",
    )
    command.add_argument(
        "--host",
        default="0.0.0.0",
        metavar="ADDRESS",
        help="address to listen on (default: all of this computer's)",
    )
    command.add_argument(
        "--port", type=int, default=8000, metavar="N", help="port to listen on (default: 8000)"
    )
    command.add_argument(
        "--address",
        metavar="URL",
        help="what links begin with, as http://robots.school.example:8000 (default: this "
        "computer's address in its network)",
    )
    command.add_argument(
        "--memory", type=int, default=1500, metavar="MB", help="limit for each student (1500)"
    )
    command.add_argument(
        "--disk", type=int, default=1000, metavar="MB", help="limit of each student's folder (1000)"
    )
    command.add_argument(
        "--idle", type=int, default=60, metavar="MINUTES", help="a robot unused so long ends (60)"
    )
    command.add_argument(
        "--shared-robot",
        metavar="ROBOT",
        help="one robot more, which the class shares by a queue: what `run --robot` takes",
    )
    command.add_argument(
        "--turn", type=float, default=3.0, metavar="MINUTES",
        help="how long each drives the shared robot, if others wait (3)",
    )  # fmt: skip
    command.add_argument(
        "--notebook",
        action="store_true",
        default=False,
        help="JupyterLab for each student, with the robot in it",
    )
    command.add_argument(
        "--write-only",
        action="store_true",
        default=False,
        help="write configuration and links, and end",
    )
    command.set_defaults(command=_class)


def add_single_user(command: CommandParser) -> None:
    """Add the options of ``single-user``; the hub's environment has the rest."""
    command.description = (
        "Serve the dashboard and the lessons to one user of a JupyterHub, which starts this as its "
        "single-user server: address, path and sign-in are as the hub's environment says."
    )
    command.add_argument("--file", type=Path, default=Path("my_filter.py"), metavar="FILE.py",
                         help="the student's file; begun if it is not there")  # fmt: skip
    command.add_argument("--lesson", type=int, default=1, metavar="N", help="the lesson to open")
    add_lessons(command)
    add_serving(command)
    command.set_defaults(command=_single_user)


def add_shared_robot(command: CommandParser) -> None:
    """Add the options of ``shared-robot``; the hub's environment has the rest."""
    command.description = (
        "Serve one robot to a class, as a service of its JupyterHub: students queue up, and one "
        "after the other drives for some minutes."
    )
    command.add_argument(
        "--turn", type=float, default=3.0, metavar="MINUTES", help="how long one drives (3)"
    )
    add_serving(command)
    command.set_defaults(command=_shared_robot)


def _class(parsed: argparse.Namespace) -> int:
    # Imported here, so that a wrong argument is refused at once.
    from app.features.classroom.class_command import serve_class  # noqa: PLC0415

    return serve_class(parsed)


def _single_user(parsed: argparse.Namespace) -> int:
    from app.features.classroom.single_user import serve_user  # noqa: PLC0415 - as above

    return serve_user(parsed, config_from)


def _shared_robot(parsed: argparse.Namespace) -> int:
    from app.features.classroom.single_user import serve_shared  # noqa: PLC0415 - as above

    return serve_shared(parsed, config_from)
