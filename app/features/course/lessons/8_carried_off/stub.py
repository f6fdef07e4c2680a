def inject(poses, fit, memory, anywhere, rng):
    """Lesson 8. Return the particles; where the fit has fallen, some of them are new.

    fit: how well the newest scan fits, from 0 on; memory.slow and memory.fast: its means over a
    long and a short time, to be updated here with the shares 0.05 and 0.5; anywhere(count): count
    new particles. Each particle is replaced with the probability 1 - fast / slow, or 0.
    """
    raise NotImplementedError
