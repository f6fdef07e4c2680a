"""``brickpose`` and ``python -m app``: signals are handled first, as imports take long."""

from app.interruption import end_at_once


def main() -> int:
    """Run the command line; return the exit code."""
    end_at_once()
    from app import command_line  # noqa: PLC0415

    return command_line.main()


if __name__ == "__main__":
    raise SystemExit(main())
