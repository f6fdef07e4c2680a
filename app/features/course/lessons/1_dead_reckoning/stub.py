def odometry(pose, left, right, track):
    """Lesson 1. Return the pose after both wheels have rolled: x, y and theta.

    pose: x, y [m] and heading theta [rad] before; left, right: how far each wheel rolled [m],
    negative backwards; track: the distance between the wheels [m]. Theta is to be in [-pi, pi).
    """
    raise NotImplementedError
