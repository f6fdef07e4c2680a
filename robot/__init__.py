"""What a robot is, knows and can do."""
