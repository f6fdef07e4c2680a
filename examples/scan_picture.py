"""Scan one picture: what the robot's camera sees, and where the rays meet tape."""

import numpy as np

from brickpose import MAPS, Config, LineScanner, build_program, load_field

field = load_field("square", MAPS)
program = build_program(Config(map="square", robot="kinematic", seed=1))
scanner = LineScanner(program.robot.spec.floor_view, program.config.scanner, field.tape)
while (frame := program.robot.read().frame) is None:
    pass
seen = scanner.scan(frame)
nearest = np.argmin(seen.scan.ranges)
print(f"{seen.scan.hit.sum()} of {len(seen.scan.ranges)} rays meet tape")
bearing, distance = np.degrees(seen.scan.bearings[nearest]), 1000 * seen.scan.ranges[nearest]
print(f"the nearest at {bearing:.0f} degrees, {distance:.1f} mm from the rays' start")
program.robot.close()
