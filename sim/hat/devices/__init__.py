"""What can be plugged into a Build HAT, and what a motor on it turns."""
