"""Commands that arrive as messages."""
