"""Work that takes long: who does it, what made it, and where it goes."""
