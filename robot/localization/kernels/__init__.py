"""Compiled loops over particles and rays.

Each module names the function of ``robot.localization.textbook`` that it speeds up.
docs/localization.md says what each trick gains; one that gains less than 15 % of an update is not
kept.
"""
