"""Times at which pictures are taken, and poses of the robot at these times."""
