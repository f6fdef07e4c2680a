"""Known motions, driven again and again by a simulated robot."""
