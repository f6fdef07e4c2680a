"""The floor that the robot drives on: drawings and ROS maps, their picture and their edges."""
