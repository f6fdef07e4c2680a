"""Where the filter starts: at the field's start, at a given pose, or where the last run ended."""
