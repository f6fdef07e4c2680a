"""What the DDS process is made of."""
