"""The program behind a reverse proxy: below a path, and as an entry of Jupyter's own proxy."""
