"""Compiled code that models, particles and filters share."""
