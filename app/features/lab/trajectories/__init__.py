"""Trajectories: reading, clock offsets, comparison and statistics."""
