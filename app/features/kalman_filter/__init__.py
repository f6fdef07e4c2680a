"""The Kalman filter (Probabilistic Robotics, 3.3 and 7.4) as a choice of ``filter``."""
