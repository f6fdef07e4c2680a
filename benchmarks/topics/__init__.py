"""Benchmarks of recordings and ROS 2."""
