"""pybullet as a choice of ``[sim] engine``: forces on the simulated robot."""
