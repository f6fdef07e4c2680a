"""The algorithms as Probabilistic Robotics (Thrun, Burgard, Fox) prints them, in plain NumPy.

The program runs compiled versions (``robot.localization.kernels``, ``robot.localization.models``).
These pages are for reading, and the tests compare the compiled versions with them.
"""
