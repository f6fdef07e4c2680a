"""Writes ``docs/configuration.md`` from the settings: ``python -m app.tools.settings_page``."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from typing import Any

from app.settings.config import ROOT, Config
from robot.settings import Setting, describe

PAGE = ROOT / "docs" / "configuration.md"

HEAD = """# Every setting

`brickpose run --config FILE.toml` reads them; a misspelt key is refused with its path. This page is
made by `python -m app.tools.settings_page`. A feature of another package has a table of its own,
with its name ([extending.md](extending.md)).

```toml
map = "town"

[drive]
max_velocity = 0.2

[localization.filter]
min_particles = 1000
```
"""


def page() -> str:
    """Return the whole page."""
    return HEAD + "".join(_tables(Config(), "")) + "\n"


def _tables(group: Any, path: str) -> Iterator[str]:
    if describe(group):
        title = f"[{path}]" if path else "Top level"
        yield f"\n## {title}\n\n{(type(group).__doc__ or '').strip()}\n"
        yield "\n| key | default | valid | meaning |\n|---|---|---|---|\n"
        for name, known in describe(group).items():
            value = getattr(group, name)
            shown = f"{value:.6g}" if isinstance(value, float) else str(value)
            cells = f"`{name}`", f"{shown} {known.unit}", _valid(known, value), known.meaning
            yield f"| {' | '.join(cells)} |\n"
    for inner in dataclasses.fields(group):
        value = getattr(group, inner.name)
        if dataclasses.is_dataclass(value):
            yield from _tables(value, f"{path}.{inner.name}" if path else inner.name)


def _valid(known: Setting, value: object) -> str:
    if known.choices:
        return ", ".join(known.choices)
    if isinstance(value, bool):
        return "true, false"
    if isinstance(value, str) or math.isinf(known.low) or math.isinf(known.high):
        return ""
    return f"{known.low:.10g} to {known.high:.10g}"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
