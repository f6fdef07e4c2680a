"""Compiled loops over particles and rays.

A module says which table of ``robot.localization.textbook`` it speeds up. What each trick is worth
is in docs/localization.md; one that gains less than 15 % of an update is not kept.
"""
