"""What drives tell of the motion and sensor models: statistics, and parameters fitted to them."""
