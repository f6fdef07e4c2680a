"""Start of a Build HAT, from an open port to the right firmware, without any I/O."""
