"""``brickpose map``: draws the tape of a floor from a recorded drive."""
