"""The Build HAT's language without any I/O: bytes to events, and commands to bytes."""
