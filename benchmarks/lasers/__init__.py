"""Benchmarks with laser robots."""
