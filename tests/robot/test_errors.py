"""Our own exceptions: all of them are errors that the program tells its users."""

import builtins
import importlib
import importlib.util
import pkgutil

import pytest

import app
import robot
import sim
from robot.errors import LONGEST, BrickPoseError, CommandError

STANDARD = tuple(
    kind
    for kind in vars(builtins).values()
    if isinstance(kind, type) and issubclass(kind, Exception) and kind is not Exception
)

ABSENT = () if importlib.util.find_spec("jupyterhub") else ("app.features.classroom.hub.",)
"""What needs packages that are not here."""


def own_exceptions() -> list[type[Exception]]:
    """The exception classes that are defined in our packages."""
    names = [
        module.name
        for package in (app, robot, sim)
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")
        if not module.name.endswith("__main__") and not module.name.startswith(ABSENT)
    ]
    return [
        item
        for module in map(importlib.import_module, names)
        for item in vars(module).values()
        if isinstance(item, type)
        and issubclass(item, Exception)
        and item.__module__ == module.__name__
        and item is not BrickPoseError
    ]


OWN = own_exceptions()


@pytest.mark.parametrize("kind", OWN, ids=lambda kind: kind.__name__)
def test_each_is_one_of_ours_and_a_standard_one(kind):
    assert issubclass(kind, BrickPoseError)
    assert issubclass(kind, STANDARD)
    assert kind.__name__.endswith("Error")
    assert str(kind("what is wrong")) == "what is wrong"


def test_no_two_have_the_same_name():
    assert len(OWN) > 30
    assert len({kind.__name__ for kind in OWN}) == len(OWN)


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("two\n  lines\r\n", "two lines"),
        ("a  b é ٣ 机", "a  b é ٣ 机"),
        ("\0 \x1b[2J \t \x7f", "\\x00 \\x1b[2J \\t \\x7f"),
        ("\ud800 \u202e \u2028 next", "\\ud800 \\u202e next"),
        ("x" * LONGEST, "x" * LONGEST),
        ("x" * 10**7, "x" * (LONGEST - 4) + " ..."),
        ("\0" * LONGEST, ("\\x00" * LONGEST)[: LONGEST - 4] + " ..."),
    ],
)
def test_a_message_is_one_line_of_text_whatever_it_quotes(text, shown):
    assert str(CommandError(text)) == shown
