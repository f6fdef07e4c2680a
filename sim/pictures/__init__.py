"""When pictures are taken and where the robot was then."""
