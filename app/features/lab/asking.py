"""Questions to a person at the terminal: ``ask_which``."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from app.console import say


def can_ask() -> bool:
    """Whether a person sits at a terminal, who can be asked."""
    return sys.stdin.isatty() and sys.stdout.isatty()


def ask_which(question: str, choices: Sequence[str], otherwise: str) -> int | None:
    """Ask for one of some choices; return its place, or None for an empty answer.

    Args:
        question: what is asked.
        choices: what can be chosen.
        otherwise: what an empty answer means.
    """
    say(question)
    for number, choice in enumerate(choices, 1):
        say(f"  {number}: {choice}")
    while True:
        say(f"Its number (only Return: {otherwise}):")
        answer = sys.stdin.readline().strip()
        if not answer:
            return None
        if answer.isdecimal() and 1 <= int(answer) <= len(choices):
            return int(answer) - 1
        say(f"{answer!r} is none of them; valid are 1 to {len(choices)}")
