"""How the camera is mounted, by one picture of the floor."""
