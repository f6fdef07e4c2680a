"""The way to a goal: free floor, a path through it, and the drive along the path."""
