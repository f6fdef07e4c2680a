"""Command language of the Build HAT's firmware: from received bytes to actions of a port."""
