"""The worlds in which the experiment is made: a robot, and how far it is from its description."""

from __future__ import annotations

from dataclasses import replace

from app.config import Config

AS_REAL_SLIP = 2.0
"""How much more the wheels slip than they are set to."""
AS_REAL_ANGLE, AS_REAL_PLACE = 0.3, 0.001
"""The camera's mounting, about and along each axis: standard deviations [degree], [m]."""
AS_REAL_LATE = 0.020
"""How much later a picture is stamped than it was exposed [s]."""
AS_REAL_LIGHT, AS_REAL_SHADOW = 0.5, "shadow"
"""Share of the light that is lost far from the lamp; and somebody stands in the light."""


def sim(config: Config) -> Config:
    """Physics and imperfections as they are set."""
    return replace(config, robot="sim")


def kinematic(config: Config) -> Config:
    """Perfect wheels, and a camera as it is set."""
    return replace(config, robot="kinematic")


def as_real(config: Config) -> Config:
    """As ``sim``, but nobody has calibrated it: it stands where a real robot would."""
    imperfections, camera = config.imperfections, config.camera
    return replace(
        config,
        robot="sim",
        imperfections=replace(
            imperfections,
            slip_sd=min(AS_REAL_SLIP * imperfections.slip_sd, 0.5),
            camera_angle_sd=max(AS_REAL_ANGLE, imperfections.camera_angle_sd),
            camera_position_sd=max(AS_REAL_PLACE, imperfections.camera_position_sd),
        ),
        camera=replace(
            camera,
            # Handed over later, too: a picture is not stamped with a time that has not come.
            delay=min(camera.delay + AS_REAL_LATE, 1.0),
            stamp_error=min(camera.stamp_error + AS_REAL_LATE, 1.0),
            uneven_light=max(AS_REAL_LIGHT, camera.uneven_light),
            clutter=AS_REAL_SHADOW if camera.clutter == "none" else camera.clutter,
        ),
    )


WORLDS = {"sim": sim, "as-real": as_real, "kinematic": kinematic}
"""By name: what a configuration becomes there."""
