"""Drives the robot to goals on the map."""
