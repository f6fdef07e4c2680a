"""Statistics of the motion and sensor models from drives, and parameters fitted to the drives."""
