"""Compiles functions before they are needed, on all cores, with progress."""
