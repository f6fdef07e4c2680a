"""``brickpose replay``: a recording on the dashboard, or through the filter to files."""
