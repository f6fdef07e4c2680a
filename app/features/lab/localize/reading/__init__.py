"""Read a bag as scans, each with the odometry at its stamp."""
