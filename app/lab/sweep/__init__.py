"""Sweeps: the experiment at many settings, kept point by point so that nothing is done twice."""
