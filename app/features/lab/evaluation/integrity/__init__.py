"""Measure integrity over robots, fields, conditions and starts, with the measures of aviation."""
