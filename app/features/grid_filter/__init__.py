"""The grid filter: a histogram of poses (Probabilistic Robotics, 4.1) as a choice of ``filter``."""
