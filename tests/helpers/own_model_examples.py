"""The examples of docs/own_models.md, as they stand there."""

import re

from app.settings.config import ROOT

PAGE = (ROOT / "docs" / "own_models.md").read_text(encoding="utf-8")
EXAMPLES = dict(re.findall(r"\n`(\w+\.py)`:[^\n]*\n\n```python\n(.*?)```\n", PAGE, re.DOTALL))
