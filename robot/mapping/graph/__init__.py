"""Walls from a laser's scans: scan matches, loops and a pose graph that holds them together."""
