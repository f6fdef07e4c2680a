"""Grid localization: a belief in boxes of poses."""
