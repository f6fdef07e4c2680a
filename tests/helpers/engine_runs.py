"""Engines stepped without threads, faster than real time."""

from app.engine.build import build_program
from app.engine.program import Program
from app.engine.snapshot import Snapshot
from app.messages.driving_commands import DriveCommand, FigureEightCommand
from app.settings.config import Config
from sim.imperfections import Imperfections
from sim.simulated import PERIOD, SimSettings

EIGHT = FigureEightCommand(type="figure_eight")


PERFECT = SimSettings(imperfections=Imperfections.none())
"""For a robot whose odometry is the truth."""


def kinematic(sim: SimSettings = PERFECT, **settings) -> Program:
    """A robot without forces, and with perfect wheels unless it is given others."""
    return build_program(Config(robot="kinematic", sim=sim, **settings))


def run(program: Program, seconds: float, *renewed) -> list[Snapshot]:
    """Step for a time, with commands renewed at each tick."""
    shown = []
    for _ in range(round(seconds / PERIOD)):
        for command in renewed:
            program.engine.commands.put(command)
        shown.append(program.engine.step())
    return shown


def drive(v=0.0, omega=0.0) -> DriveCommand:
    return DriveCommand(type="drive", v=v, omega=omega)
