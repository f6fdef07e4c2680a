"""From a wanted velocity to the wheels, and from the wheels back to a pose."""
