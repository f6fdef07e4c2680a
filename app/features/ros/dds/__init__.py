"""The topics over DDS, in a separate process that speaks it like the nodes of ROS 2."""
