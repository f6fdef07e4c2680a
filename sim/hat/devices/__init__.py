"""Devices that can be plugged into a Build HAT, and the physics of its motors."""
