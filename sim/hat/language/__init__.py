"""The command language of the Build HAT's firmware: from bytes to what a port shall do."""
