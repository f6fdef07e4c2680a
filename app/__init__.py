"""The program: engine, server, views and command line."""

from app.feature import Late
from robot import hooks

# So the robot's rooms find what features add in every process that has the program, workers too.
hooks.find_by(Late("app.engine.plugging:plugged"))
