"""Multi-hypothesis localization: places are found by a short map, tracked, and weighed by rays."""
