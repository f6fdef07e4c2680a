"""The entry of jupyter-server-proxy: the dashboard in JupyterLab's launcher."""

from __future__ import annotations

import secrets
import sys
from typing import Any

from app.settings.config import FRONTEND

NAME = "brickpose"
"""Of the entry: the dashboard is at this path, below Jupyter's."""
START_S = 180
"""Time for a start [s]; a first one compiles, a minute on a usual computer."""


def server() -> dict[str, Any]:
    """Return how jupyter-server-proxy starts the dashboard, and shows it in the launcher."""
    # Who comes to Jupyter has signed in there, so its proxy has the token; others have not.
    token = secrets.token_urlsafe(18)
    return {
        "command": [
            sys.executable, "-m", "app", "run", "--port", "{port}",
            "--root-path", f"{{base_url}}{NAME}/", "--allow-code",
        ],
        "environment": {"BRICKPOSE_TOKEN": token},
        "request_headers_override": {"Authorization": f"Bearer {token}"},
        "timeout": START_S,
        "launcher_entry": {"title": "BrickPose", "icon_path": str(FRONTEND / "icon.svg")},
    }  # fmt: skip
