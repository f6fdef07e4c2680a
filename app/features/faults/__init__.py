"""Faults of a simulated robot, which the page sets while it drives."""
