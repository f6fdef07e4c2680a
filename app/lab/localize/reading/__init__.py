"""From a bag to scans, each with the odometry of its stamp."""
