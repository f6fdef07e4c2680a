"""Benchmarks on pictures that real robots took."""
