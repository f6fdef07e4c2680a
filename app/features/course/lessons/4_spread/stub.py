def motion(poses, moved, alphas, rng):
    """Lesson 4. Return the particles (n, 3) after a step, each with its own noise.

    poses: (n, 3); moved: dx, dy [m], turn [rad], seen from the robot before the step; alphas:
    alpha1 to alpha4; rng: the only source of chance, as rng.standard_normal(n).
    Theta is to be in [-pi, pi).
    A step is a rotation rot1 towards its end, a way, and a rotation rot2. A step with dx < 0 is
    driven backwards: its way is negative. Variances: alpha1 rot² + alpha2 way² of each rotation,
    alpha3 way² + alpha4 (rot1² + rot2²) of the way.
    """
    raise NotImplementedError
