"""``brickpose`` and ``python -m app``: signals are handled first, as imports take long."""

import gc
import os

from app.interruption import end_at_once

# Matrices are small here: a second thread of BLAS waits for the first, and takes the core from the
# control loop meanwhile. It is read when NumPy is imported, also by processes that are begun.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def main() -> int:
    """Run the command line; return the exit code."""
    end_at_once()
    # What is loaded stays: looking for garbage in it would be a seventh of a start.
    gc.disable()
    from app import command_line, console  # noqa: PLC0415

    console.never_fail_to_print()

    return command_line.main()


if __name__ == "__main__":
    raise SystemExit(main())
