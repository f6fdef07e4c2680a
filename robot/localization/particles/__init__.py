"""The particle filter and what it is made of."""
