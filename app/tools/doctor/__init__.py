"""``brickpose doctor``: finds what is wrong with this machine or robot, and says what to do."""
