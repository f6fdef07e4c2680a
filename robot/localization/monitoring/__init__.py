"""Checks whether scans and odometry agree with the models; if not, by how much and why."""
