"""Compare settings over seeds: how exact is the filter with few and with many particles?"""

import math

import numpy as np

from brickpose import Config, FigureEightCommand, LocalizationParameters, build_program
from robot.localization.parameters import FilterParameters

for particles in (50, 500):
    chosen = FilterParameters(filter="particles", min_particles=50, max_particles=particles)
    errors = []
    for seed in range(3):
        localization = LocalizationParameters(filter=chosen)
        config = Config(map="stub", robot="kinematic", seed=seed, localization=localization)
        program = build_program(config)
        for _ in range(250):
            program.engine.commands.put(FigureEightCommand(type="figure_eight"))
            now = program.engine.step()
            if now.pose and now.truth:
                errors.append(math.dist((now.pose.x, now.pose.y), (now.truth.x, now.truth.y)))
        program.robot.close()
    print(f"{particles} particles: {1000 * np.sqrt(np.mean(np.square(errors))):.1f} mm")
