"""What plugs into the core, a folder each; ``feature.py`` in it says what it adds."""
