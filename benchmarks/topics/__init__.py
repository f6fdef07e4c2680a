"""Recordings and ROS 2."""
