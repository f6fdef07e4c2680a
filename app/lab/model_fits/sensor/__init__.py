"""Measured ranges beside exact ones: how they err, and the beam model fitted to them."""
