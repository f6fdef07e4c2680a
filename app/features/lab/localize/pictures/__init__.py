"""A folder of pictures on a taped field."""
