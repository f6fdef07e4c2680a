"""What a recording has, as a robot would have told it."""
