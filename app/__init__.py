"""The program: engine, server, views and command line."""

from typing import TYPE_CHECKING

from robot import hooks

if TYPE_CHECKING:
    from app.engine.plugging import Plugged


def _plugged() -> "Plugged":
    from app.engine.plugging import plugged  # noqa: PLC0415 - signals are to be handled first

    return plugged()


# So the robot's rooms find what features add in every process that has the program, workers too.
hooks.find_by(_plugged)
