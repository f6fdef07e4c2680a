"""The topics for Foxglove and Lichtblick."""
