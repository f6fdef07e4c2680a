"""The robot and the floor as a MuJoCo model, built from our own rigid bodies.

MuJoCo's contacts and motors are no rules but springs and dampers that the engine solves for, and
what slides is lifted a little. The constants here let a wheel roll, slip and lock as Coulomb's law
says, a robot stand, and a motor reach its speed (``tests/sim/test_engines.py``). Beside each is
what other values gave: the slip of the tyres over 20 hard starts and stops, as a share of what
Coulomb's law says at mu 0.5, 0.3 and 0.1, is 0.88, 1.00 and 0.98 with these.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from robot.description.rigid_bodies import RigidBody
from robot.description.spec import JointSpec
from robot.description.urdf import Solid
from robot.geometry import Array
from sim.physics import GRAVITY, PhysicsSettings

FLOOR = "floor"

STIFFEST = 2.0
"""Shortest time constant of a contact that MuJoCo integrates without overshoot, in steps: what
disturbs it is gone after one step."""
TYRE_GRIP = 4.0
"""Time constant of the tyres' friction, in steps. In a bend at 0.15 m/s the robot drifts aside by
0.24 mm/s, which the filter cannot know of: by 0.30 with 5, though slip is then 0.98, 1.01 and 1.00;
by 0.59 with 10. With 3 slip is 0.80, 0.91 and 0.95."""
CASTER_GRIP = 25.0
"""Time constant of the caster's friction, in steps. Sliding lifts it and tilts the robot by 0.003
degrees at 0.15 m/s; by 0.007 with 10. With 50 a slow caster glides as in oil, and slip is 0.86,
0.94 and 0.93."""
CONTACT_HARDNESS = 0.5
"""How hard contacts are, 0 to 1. The weight presses the tyres into the floor by 72 um, for which
``_settle`` makes up. Harder ones, 0.8, lose the floor when they slip: 0.90, 0.92 and 0.88."""
FRICTION_HARDNESS = 1000.0
"""How much harder friction is than the contact that carries it; with 1 a tyre creeps by 0.3 %."""
CLUTCH = 0.9999
"""How hard the motors' clutches are: the hardest that there is. A wheel that pulls the caster falls
behind its shaft by 0.0006 % of its speed; with 0.99 by 0.06 %."""

SETTLINGS = 3
"""How often the robot is let settle; after the third nothing moves by more than 0.1 um."""
SETTLING_STEPS = 100
"""Steps of the physics, each time."""

SHAFT = 1e3
"""Inertia of a motor's shaft [kg m^2], so large that no wheel slows it."""


def build_model(
    mujoco: Any, bodies: list[RigidBody], joints: tuple[JointSpec, ...], settings: PhysicsSettings
) -> Any:
    """Return the compiled model; its first freedoms are the root's 6, then the bodies' joints.

    A motor is a shaft whose speed follows the command with a first-order lag, and a clutch between
    shaft and wheel that slips above the motor's torque limit. Position and velocity of a shaft are
    those of a joint named ``shaft_name``; joint, clutch and command of a motor have its joint's
    name.
    """
    spec = mujoco.MjSpec()
    spec.option.timestep = settings.step_time
    spec.option.gravity = [0, 0, -GRAVITY]
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = FRICTION_HARDNESS
    # By default a motion that explodes begins again at the origin, and nobody is told.
    spec.option.disableflags = mujoco.mjtDisableBit.mjDSBL_AUTORESET
    spec.worldbody.add_geom(
        name=FLOOR, type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1], contype=0, conaffinity=0
    )
    driven = {joint.name for joint in joints}
    made: list[Any] = []
    for body in bodies:
        holder = spec.worldbody if body.parent < 0 else made[body.parent]
        made.append(_add_body(mujoco, holder, body))
        for number, (shape, body_from_shape) in enumerate(body.collisions):
            geom = f"{body.name} {number}"
            _add_shape(mujoco, made[-1], geom, shape, body_from_shape)
            _add_contact(spec, geom, settings, body.joint in driven)
    for joint in joints:
        _add_motor(mujoco, spec, joint, settings)
    model = spec.compile()
    _settle(mujoco, model)
    return model


def _settle(mujoco: Any, model: Any) -> None:
    """Let contacts begin so far above the floor that the robot at rest just touches it."""
    data = mujoco.MjData(model)
    pairs = {int(geom): number for number, geom in enumerate(model.pair_geom2)}
    for _ in range(SETTLINGS):
        mujoco.mj_resetData(model, data)
        mujoco.mj_step(model, data, SETTLING_STEPS)
        for contact in data.contact[: data.ncon]:
            model.pair_margin[pairs[int(contact.geom2)]] -= contact.dist


def _add_body(mujoco: Any, holder: Any, body: RigidBody) -> Any:
    tensor = body.inertia
    made = holder.add_body(
        name=body.name,
        pos=body.parent_from_body[:3, 3],
        quat=_quaternion(body.parent_from_body),
        mass=body.mass,
        ipos=body.centre,
        fullinertia=[*np.diag(tensor), tensor[0, 1], tensor[0, 2], tensor[1, 2]],
        explicitinertial=True,
    )
    if body.joint is None:
        made.add_freejoint()
    else:
        made.add_joint(name=body.joint, type=mujoco.mjtJoint.mjJNT_HINGE, axis=body.axis)
    return made


def _add_shape(mujoco: Any, body: Any, name: str, shape: Solid, body_from_shape: Array) -> None:
    sizes = {
        "box": lambda: (mujoco.mjtGeom.mjGEOM_BOX, [edge / 2 for edge in shape.size]),
        "cylinder": lambda: (
            mujoco.mjtGeom.mjGEOM_CYLINDER,
            [shape.size[0], shape.size[1] / 2, 0],
        ),
        "sphere": lambda: (mujoco.mjtGeom.mjGEOM_SPHERE, [shape.size[0], 0, 0]),
    }
    kind, size = sizes[shape.kind]()
    body.add_geom(
        name=name,
        type=kind,
        size=size,
        pos=body_from_shape[:3, 3],
        quat=_quaternion(body_from_shape),
        contype=0,
        conaffinity=0,
    )


def _add_contact(spec: Any, geom: str, settings: PhysicsSettings, is_tyre: bool) -> None:
    """Let a shape touch the floor; the robot's own parts never touch each other."""
    mu = settings.friction if is_tyre else settings.caster_friction
    spec.add_pair(
        name=geom,
        geomname1=FLOOR,
        geomname2=geom,
        condim=3,
        friction=[mu, mu, 0, 0, 0],
        solref=[STIFFEST * settings.step_time, 1],
        solreffriction=[(TYRE_GRIP if is_tyre else CASTER_GRIP) * settings.step_time, 1],
        solimp=_constant(CONTACT_HARDNESS),
    )


def _add_motor(mujoco: Any, spec: Any, joint: JointSpec, settings: PhysicsSettings) -> None:
    name = shaft_name(joint.name)
    shaft = spec.worldbody.add_body(
        name=name, mass=1e-3, inertia=[1e-6, 1e-6, 1e-6], explicitinertial=True
    )
    shaft.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 1, 0], armature=SHAFT)
    clutch = spec.add_tendon(
        name=joint.name,
        frictionloss=joint.max_effort,
        solref_friction=[STIFFEST * settings.step_time, 1],
        solimp_friction=_constant(CLUTCH),
    )
    clutch.wrap_joint(joint.name, 1)
    clutch.wrap_joint(name, -1)
    # Each step moves the shaft's speed by this share of what is missing, exactly: the shaft has no
    # other force worth mentioning, and the integrator is Euler's.
    lag = settings.motor_lag
    share = 1 - math.exp(-settings.step_time / lag) if lag > 0 else 1.0
    gain = SHAFT * share / settings.step_time
    spec.add_actuator(
        name=joint.name,
        target=name,
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        gainprm=[gain, *[0] * 9],
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        biasprm=[0, 0, -gain, *[0] * 7],
    )


def shaft_name(joint: str) -> str:
    """Return the name of the joint that a motor's shaft turns on."""
    return f"{joint} shaft"


def _constant(hardness: float) -> list[float]:
    """Return MuJoCo's impedance that is the same at every depth."""
    return [hardness, hardness, 0.001, 0.5, 2]


def _quaternion(transform: Array) -> Array:
    """Return the rotation of a transform (4, 4) as MuJoCo has it: the scalar first."""
    quaternion: Array = Rotation.from_matrix(transform[:3, :3]).as_quat(scalar_first=True)
    return quaternion
