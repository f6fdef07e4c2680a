"""Simulated robots with the same interface as the real one."""
