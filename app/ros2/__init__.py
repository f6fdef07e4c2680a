"""A standard ROS 2 robot without ROS: one list of topics, one of commands, several routes."""
