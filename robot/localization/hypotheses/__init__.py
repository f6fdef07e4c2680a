"""Several places at once: found by a short map, tracked each by itself, weighed by rays."""
