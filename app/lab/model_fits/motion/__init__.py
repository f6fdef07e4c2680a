"""Odometry with truth: its steady errors, the alphas of what is left, and what regions hold."""
