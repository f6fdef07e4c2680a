"""Compiles all functions, so that the first start is quick: ``python -m app.tools.warm_up``."""

from __future__ import annotations

from app.engine.compiling.terminal import compile_first

if __name__ == "__main__":
    compile_first()
