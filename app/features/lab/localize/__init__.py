"""``brickpose localize``: localizes any laser robot from its bag."""
