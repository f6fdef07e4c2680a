"""Finds texts for people in JavaScript: what is given to ``t`` and ``tn``."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator

STRING = r'"(?:[^"\\\n]|\\.)*"'
CALL = re.compile(rf"(?<![\w.#])tn?\(\s*(?:({STRING})(?:,\s*({STRING}))?)?")
DEFINITION = "function "


def texts_of_script(script: str) -> Iterator[str | tuple[str, str]]:
    """Yield the texts of a script; of ``tn`` singular and plural.

    Raises:
        ValueError: a text is not written out where it is used, so that it cannot be found.
    """
    for call in CALL.finditer(script):
        if script[: call.start()].endswith(DEFINITION):
            continue
        singular, plural = call.groups()
        if singular is None or (call[0].startswith("tn") and plural is None):
            line = script.count("\n", 0, call.start()) + 1
            raise ValueError(f"line {line}: a text has to be written out, in double quotes")
        if call[0].startswith("tn"):
            yield json.loads(singular), json.loads(plural)
        else:
            yield json.loads(singular)
