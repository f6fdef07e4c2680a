"""Robots with lasers."""
