"""The 3D view: viser, served on our own port."""
