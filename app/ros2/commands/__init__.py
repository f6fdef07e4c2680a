"""Commands that come as messages."""
