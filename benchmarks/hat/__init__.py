"""Measurements of the robot in bricks, on the emulated Build HAT."""
