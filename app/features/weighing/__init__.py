"""Shows what a scan says of single particles, and steps the filter by hand."""
