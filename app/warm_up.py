"""Compiles what is compiled, so that the first start is quick: ``python -m app.warm_up``."""

from __future__ import annotations

from app.assembly import assemble
from app.config import Config
from app.messages.commands import FigureEightCommand, SetParametersCommand


def _sensor(model: str) -> SetParametersCommand:
    return SetParametersCommand(type="set_parameters", values={"laser_model_type": model})


if __name__ == "__main__":
    program = assemble(Config(robot="kinematic"))
    program.engine.commands.put(_sensor("beam"))
    for tick in range(20):
        if tick == 10:
            program.engine.commands.put(_sensor("likelihood_field"))
        program.engine.commands.put(FigureEightCommand(type="figure_eight"))
        program.engine.step()
    program.robot.close()
