"""The language that a command of the course speaks, and that a student's file begins in."""

from __future__ import annotations

import argparse
import os

from app.languages.catalogue import Catalogue, catalogue, languages, spoken
from robot.settings import SettingError


def language_asked(parsed: argparse.Namespace) -> Catalogue:
    """Return the language that ``--language`` names, else the environment's.

    Raises:
        SettingError: there is no such language.
    """
    code = getattr(parsed, "language", None)
    if code is None:
        return spoken()
    if code not in languages():
        raise SettingError(f"there is no language {code}; valid are {', '.join(languages())}")
    os.environ["LANGUAGE"] = code  # what else the command says is in it, too
    return catalogue(code)
