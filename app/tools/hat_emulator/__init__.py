"""``brickpose emulate-hat``: a Build HAT without the board."""
