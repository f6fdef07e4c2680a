"""Converts a snapshot to the messages of the topics."""
