"""Measures the robot that was built while it drives, its lens, and follows what drifts."""
