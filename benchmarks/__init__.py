"""Benchmarks of the program, side by side with peers."""
