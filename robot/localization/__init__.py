"""Where is the robot? Monte Carlo localization, after Probabilistic Robotics, chapters 4 to 8."""
