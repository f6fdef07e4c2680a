def project(u, v, camera):
    """Lesson 2. Return bearing [rad] and range [m] of the floor point that a pixel shows.

    u, v: the pixel, to the right and down [px]; camera.focal [px], camera.u0, camera.v0: the
    picture's middle [px]; camera.height [m], camera.tilt: how far it looks down [degrees],
    camera.forward: how far ahead of the axle it sits [m]. Bearing and range count from the axle;
    bearings are positive to the left. Above the horizon the range is math.inf, and the bearing
    any number.
    """
    raise NotImplementedError
