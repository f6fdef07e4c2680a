"""Presents the content of a recording in the way a robot would."""
