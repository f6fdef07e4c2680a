"""Names tape that does not lie where the drawing has it, and does without it until it does."""
