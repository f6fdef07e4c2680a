"""Runs a student's code in a process of its own, which can harm nothing and read no answers."""
