"""Columns of the rays (n, 9) that ``rays_of`` makes of a scan; compiled functions read them, too.

Numbers instead of an enumeration: numba compiles these as constants, and an enumeration slowly.
"""

X = 0
"""Where the ray starts, in the robot frame [m]."""
Y = 1
DIRECTION = 2
"""In the robot frame [rad]."""
RANGE = 3
"""[m]; infinite without a return."""
NEAR = 4
"""The nearest distance that the ray sees [m]; nan if it sees nowhere."""
FAR = 5
"""The farthest [m]."""
CLEAR = 6
"""Probability that it returns an edge which is there."""
HIDDEN_FROM = 7
"""Where something begins that may hide an edge [m]; infinite if there is nothing."""
HIDDEN_TO = 8
"""Where it ends [m]; minus infinite if there is nothing."""
NUMBER = 9
