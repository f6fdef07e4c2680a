"""Evaluation, fits, sweeps, trajectories, laser bags: the live program never imports it."""
