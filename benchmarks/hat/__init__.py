"""Benchmarks of the LEGO robot, on the emulated Build HAT."""
