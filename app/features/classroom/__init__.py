"""A class of students, each with a robot: JupyterHub, whose single-user server is the dashboard."""
