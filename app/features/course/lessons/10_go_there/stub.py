def go_there(pose, path, goal, speed, ahead, delay):
    """Lesson 10. Return speed [m/s] and turning speed [rad/s] that bring a robot to its goal.

    pose, goal: x, y [m] and heading [rad]; path: (n, 2) x, y along the way, the last is the goal's;
    speed: along the way [m/s]; ahead: the look-ahead distance [m]; delay: after this time the
    wheels turn as they are told [s].
    """
    raise NotImplementedError
