"""Writes ``docs/configuration.md`` from the settings: ``python -m app.tools.settings_page``."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping
from typing import Any

from app.feature import SettingOption
from app.feature_search import OURS, find_features
from app.options import SETTINGS
from app.settings.config import ROOT, Config
from robot.settings import Setting, describe

PAGE = ROOT / "docs" / "configuration.md"

HEAD = """# Every setting

`brickpose run --config FILE.toml` reads them; a misspelt key is refused with its path. This page is
made by `python -m app.tools.settings_page`. An option of `run` that sets the same stands beside its
key. A feature of another package has a table of its own, with its name
([extending.md](extending.md)).

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
    every = find_features()
    features = [feature for feature in every.active if every.packages[feature.name] == OURS]
    added = (option for feature in features for option in feature.run_options)
    options = [*SETTINGS.values(), *(each for each in added if isinstance(each, SettingOption))]
    flags = {option.path: f" `{option.flag}`" for option in options}
    tables = [("", Config()), *((f.name, f.settings()) for f in features if f.settings)]
    return (
        HEAD + "".join(row for path, group in tables for row in _tables(group, path, flags)) + "\n"
    )


def _tables(group: Any, path: str, flags: Mapping[str, str]) -> Iterator[str]:
    above = f"{path}." if path else ""
    if describe(group):
        title = f"[{path}]" if path else "Top level"
        yield f"\n## {title}\n\n{(type(group).__doc__ or '').strip()}\n"
        yield "\n| key | default | valid | meaning |\n|---|---|---|---|\n"
        for name, known in describe(group).items():
            value = getattr(group, name)
            shown = f"{value:.6g}" if isinstance(value, float) else str(value)
            key = f"`{name}`{flags.get(above + name, '')}"
            cells = key, f"{shown} {known.unit}", _valid(known, value), known.meaning
            yield f"| {' | '.join(cells)} |\n"
    for inner in dataclasses.fields(group):
        value = getattr(group, inner.name)
        if dataclasses.is_dataclass(value):
            yield from _tables(value, above + inner.name, flags)


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
