"""Trajectories: read, put on one clock, compared, and what the comparison says."""
