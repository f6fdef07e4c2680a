"""The parts of the DDS process."""
