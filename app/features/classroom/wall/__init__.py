"""The teacher's wall: a service of the hub that shows and orders all robots of a class."""
