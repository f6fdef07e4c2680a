"""``brickpose calibrate``: measures the robot that was built."""
