"""What a soak test does to a running program, and to everything around it."""
