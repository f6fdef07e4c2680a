"""``python -m benchmarks`` is ``brickpose bench``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from app.interruption import Interrupted, end_at_once, interruptible
from robot.settings import SettingError


def main() -> int:
    """Run the benchmarks that the command line names; return 2 if a name is unknown."""
    end_at_once()
    # Imported here, so that signals are handled meanwhile.
    from benchmarks.run import run  # noqa: PLC0415

    parser = argparse.ArgumentParser(prog="brickpose bench", allow_abbrev=False)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--minutes", type=float)
    parsed = parser.parse_args()
    try:
        with interruptible():
            return run(parsed.names, parsed.json, parsed.minutes)
    except (OSError, ValueError, ImportError, RuntimeError) as error:
        sys.stderr.write(f"brickpose: {error}\n")
        return 2 if isinstance(error, SettingError) else 1
    except Interrupted as interrupted:
        return interrupted.code


if __name__ == "__main__":
    raise SystemExit(main())
