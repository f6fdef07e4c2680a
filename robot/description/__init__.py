"""The robot's description: dimensions, masses, joints and camera, all from one URDF."""
