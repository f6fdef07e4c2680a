"""Replay: a recording takes the place of the robot, and the filter runs again on it."""
