"""The topics over DDS, in a process of its own, as the nodes of ROS 2 speak it."""
