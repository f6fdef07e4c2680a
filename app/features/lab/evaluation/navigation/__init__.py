"""Measure journeys: random goals, robots that are pushed or carried off, and closed curves."""
