"""Starts JupyterHub, without what it imports and never uses."""

from __future__ import annotations

import sys

UNUSED = "rfc3987_syntax"
"""A format of JSON that the hub's own events do not have. It builds a grammar when it is imported:
half of the 2.5 s of a core that a hub needs to start, for which a class waits whose hub was
killed."""


def main() -> None:
    """Be JupyterHub, by its own command line."""
    sys.modules[UNUSED] = None  # type: ignore[assignment] # to import it is an ImportError then
    from jupyterhub.app import main as serve  # noqa: PLC0415 - after that

    serve()


if __name__ == "__main__":
    main()
