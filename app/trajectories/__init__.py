"""Trajectories, and the text file that they are written to."""
