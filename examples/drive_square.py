"""Drive a square of 30 cm without a server, and compare wheels, filter and truth."""

import math

from brickpose import Config, DriveCommand, Pose2, Snapshot, build_program

SIDE_S, CORNER_S = 3.0, 2.0  # times of a side and of a corner [s]

program = build_program(Config(map="square", robot="kinematic", seed=1))


def drive(v: float, omega: float, seconds: float) -> Snapshot:
    """Drive at v [m/s] and omega [rad/s] for a while; a command holds for 0.3 s."""
    first = last = program.engine.step()
    while last.stamp < first.stamp + seconds:
        program.engine.commands.put(DriveCommand(type="drive", v=v, omega=omega))
        last = program.engine.step()
    return last


def off(pose: Pose2 | None, truth: Pose2 | None) -> str:
    """Say how far a pose is from the true one."""
    assert pose and truth
    return f"{1000 * math.hypot(pose.x - truth.x, pose.y - truth.y):.1f} mm off"


for corner in range(4):
    drive(0.1, 0.0, SIDE_S)
    seen = drive(0.0, math.pi / 2 / CORNER_S, CORNER_S)
    print(
        f"corner {corner + 1}: the filter is {off(seen.pose, seen.truth)}, {seen.integrity.state}"
    )
program.robot.close()
