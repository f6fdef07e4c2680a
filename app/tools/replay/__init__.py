"""``brickpose replay``: shows a recording on the dashboard, or runs the filter on it to files."""
