"""A standard ROS 2 robot without ROS: a list of topics, a list of commands, several routes."""
