"""Calibration: what the built robot is like, measured by driving it over a known field."""
