"""Fields that nobody drew: ordinary drawings, made from a seed."""
