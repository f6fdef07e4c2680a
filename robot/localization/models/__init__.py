"""How odometry and scans err: motion models and sensor models."""
