"""Monte Carlo localization of the robot, after Probabilistic Robotics, chapters 4 to 8."""
