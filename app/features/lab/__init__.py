"""Evaluation, fits, sweeps, trajectories and laser bags; the live program never imports them."""
