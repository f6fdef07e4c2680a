"""``python -m benchmarks`` is ``brickpose bench``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from benchmarks.run import run
from robot.settings import SettingError


def main() -> int:
    """Run the benchmarks that the command line names; return 2 if a name is unknown."""
    parser = argparse.ArgumentParser(prog="brickpose bench", allow_abbrev=False)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--json", type=Path)
    parsed = parser.parse_args()
    try:
        return run(parsed.names, parsed.json)
    except (OSError, ValueError, ImportError, RuntimeError) as error:
        sys.stderr.write(f"brickpose: {error}\n")
        return 2 if isinstance(error, SettingError) else 1


if __name__ == "__main__":
    raise SystemExit(main())
