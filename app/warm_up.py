"""Compiles what is compiled, so that the first start is quick: ``python -m app.warm_up``."""

from __future__ import annotations

from app.assembly import assemble
from app.config import Config
from app.messages import FigureEightCommand, SetParametersCommand

if __name__ == "__main__":
    program = assemble(Config(robot="kinematic"))
    beam = {"laser_model_type": "beam"}
    program.engine.commands.put(SetParametersCommand(type="set_parameters", values=beam))
    for tick in range(20):
        if tick == 10:
            field = {"laser_model_type": "likelihood_field"}
            program.engine.commands.put(SetParametersCommand(type="set_parameters", values=field))
        program.engine.commands.put(FigureEightCommand(type="figure_eight"))
        program.engine.step()
    program.robot.close()
