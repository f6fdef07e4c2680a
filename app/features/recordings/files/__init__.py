"""Recordings as files: rosbag2 folders with MCAP."""
