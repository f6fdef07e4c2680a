"""Finds which thought is wrong in a student's code, by small cases."""
