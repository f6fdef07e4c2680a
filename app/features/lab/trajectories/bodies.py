"""Chooses one of the rigid bodies that a motion capture has followed."""

from __future__ import annotations

from collections.abc import Collection

from app.trajectories.trajectory import TrajectoryError


def chosen_body(bodies: Collection[str], body: str | None, where: str) -> str:
    """Return the name of the requested body, or of the only one.

    Args:
        bodies: those that there are, one at least.
        body: the requested one; None if that was not said.
        where: the file and the line that names them, for messages.

    Raises:
        TrajectoryError: there are several and none is requested, or one that is not there.
    """
    names = ", ".join(map(repr, bodies))
    if body is None and len(bodies) > 1:
        raise TrajectoryError(f"{where}: several rigid bodies; name one of {names}")
    if body is not None and body not in bodies:
        raise TrajectoryError(f"{where}: no rigid body {body!r}; valid are {names}")
    return next(iter(bodies)) if body is None else body
