"""Finds the piece of tape that does not lie where the drawing has it, or is not there."""
