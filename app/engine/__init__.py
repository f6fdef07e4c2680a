"""What runs once a tick: robot, odometry, filter, who drives, and what everybody sees of it."""
