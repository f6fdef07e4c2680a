"""From a velocity command to the wheels, and from the wheels' readings to a pose."""
