"""The command line of ``brickpose sweep``; slow imports are delayed until they are used."""

from __future__ import annotations

import argparse
from pathlib import Path

from app.command_parser import CommandParser
from app.condition_option import add_condition
from app.features.lab.evaluate_options import add_workers
from app.interruption import interruptible
from app.options import add_config

EXAMPLE = """\
A sweep file names settings by their path (docs/configuration.md) and their values:

  [sweep]
  seeds = 4                # robots at each point
  laps = 1
  worlds = ["sim"]         # sim, as-real, hand-built, kinematic
  # conditions = ["default", "askew"]   # as --condition
  # sample = 30            # this many random points instead of all combinations
  # offset = [-0.1, -0.1, 0.3]   # the given start is off by this [m, m, rad]

  [settings]
  localization.sensor.sigma_hit = [0.001, 0.003, 0.01]
  localization.filter.min_particles = [100, 500]
  # with sample: { low = 0.01, high = 1.0, log = true }

The same command again continues where it was interrupted.
"""


def add_sweep(command: CommandParser) -> None:
    """Add the options of ``sweep``."""
    command.description = "Make the experiment at many settings; write a table and a plot for each."
    command.epilog = EXAMPLE
    command.formatter_class = argparse.RawDescriptionHelpFormatter
    command.add_argument("file", type=Path, metavar="FILE.toml", help="what to sweep")
    add_config(command)
    add_condition(command, many=True)
    command.add_argument(
        "--out", type=Path, metavar="DIR", default=None,
        help="where the results go (default: sweeps/ and the file's name)",
    )  # fmt: skip
    command.add_argument("--format", default="csv", help="of the table: csv (default) or parquet")
    add_workers(command)
    command.set_defaults(command=_sweep)


def _sweep(parsed: argparse.Namespace) -> int:
    from app.features.lab.sweep.command import sweep_command  # noqa: PLC0415

    with interruptible():
        return sweep_command(parsed)
