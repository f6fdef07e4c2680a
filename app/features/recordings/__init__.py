"""Recordings: everything that a run shows, as an MCAP file with ROS 2 messages."""
