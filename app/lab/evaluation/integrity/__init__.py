"""Is it right when it says so? Robots, fields, conditions and starts, counted as aviation does."""
