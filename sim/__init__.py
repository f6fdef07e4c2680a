"""Simulated robots behind the same interface as the real one."""
