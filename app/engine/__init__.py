"""The work of one tick: robot, odometry, filter, driving and the published snapshot."""
