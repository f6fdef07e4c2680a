"""Everything that can be set, conditions by name, and what made a result."""
