"""The textbook's way to draw a map: an occupancy grid for each particle (FastSLAM)."""
