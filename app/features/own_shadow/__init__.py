"""Leaves out of scans what travels with the robot, as the shadow of its mast or a cable."""
