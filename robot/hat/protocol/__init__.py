"""The Build HAT's protocol without any I/O: bytes to events, and commands to bytes."""
