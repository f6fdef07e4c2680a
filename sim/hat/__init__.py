"""Emulation of the Build HAT and its firmware: bytes in, bytes out, and motors that turn."""
