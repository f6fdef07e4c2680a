"""``brickpose doctor``: what is wrong with this machine or this robot, and what to do about it."""
