"""Files for people who have ROS 2: description, controller and nav2 parameters, map."""
