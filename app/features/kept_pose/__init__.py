"""Keeps the robot's pose from one run to the next."""
