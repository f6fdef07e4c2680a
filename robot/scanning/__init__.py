"""From a camera picture to distances, as if a laser had measured them."""
