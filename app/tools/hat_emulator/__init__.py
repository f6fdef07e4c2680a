"""``brickpose emulate-hat``: an emulated Build HAT."""
