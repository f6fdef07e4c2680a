"""``brickpose localize``: any laser robot's bag through the filter."""
