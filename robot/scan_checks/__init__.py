"""What one scan after another tells: what travels along, plugs, and late pictures."""
