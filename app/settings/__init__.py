"""Settings, named conditions, and the provenance of a result."""
