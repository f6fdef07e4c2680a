"""From an open port to a Build HAT that runs the right firmware, without any I/O."""
