"""Generated fields: ordinary drawings, made from a seed."""
