"""Draws the map of a floor while the robot drives on it."""
