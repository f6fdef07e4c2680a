"""The whole program in a loop of one's own, faster than real time: ten seconds of figure-eight."""

from brickpose import Config, FigureEightCommand, build_program

program = build_program(Config(map="stub", seed=1))
for _ in range(500):
    program.engine.commands.put(FigureEightCommand(type="figure_eight"))
    snapshot = program.engine.step()
print(snapshot.pose, snapshot.truth, snapshot.integrity.state)
program.robot.close()
