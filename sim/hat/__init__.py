"""The Build HAT as its firmware behaves: bytes in, bytes out, motors turning in between."""
