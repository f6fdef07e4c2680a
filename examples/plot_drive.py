"""Plot a drive: the true path, that of the wheels and that of the filter, as drive.svg."""

import sys

import numpy as np
from matplotlib.figure import Figure

from brickpose import MAPS, Config, FigureEightCommand, build_program, load_field

program = build_program(Config(map="square", seed=1))
paths: dict[str, list[tuple[float, float]]] = {"truth": [], "odometry": [], "estimate": []}
for _ in range(800):
    program.engine.commands.put(FigureEightCommand(type="figure_eight"))
    snapshot = program.engine.step()
    poses = (snapshot.truth, snapshot.odometry, snapshot.pose)
    for path, pose in zip(paths.values(), poses, strict=True):
        path.append((pose.x, pose.y) if pose else (np.nan, np.nan))
program.robot.close()

figure = Figure(figsize=(6, 6))
axes = figure.add_subplot(aspect="equal", xlabel="x [m]", ylabel="y [m]")
for x0, y0, x1, y1 in load_field("square", MAPS).edges:
    axes.plot([x0, x1], [y0, y1], color="black", linewidth=1)
for name, path in paths.items():
    axes.plot(*np.transpose(path), label=name)
axes.legend()
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "drive.svg")
