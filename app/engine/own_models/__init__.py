"""Models in files of a user's own: loaded, watched, and never trusted to work."""
