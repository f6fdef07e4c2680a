"""The choice of the physics engine: pybullet where it is installed, elsewhere MuJoCo."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import metadata
from importlib.util import find_spec
from types import MappingProxyType

from robot.description.spec import RobotSpec
from robot.errors import PackageError
from robot.geometry import Pose2
from sim.physics import ENGINES, PhysicsSettings, PhysicsWorld


@dataclass(frozen=True)
class PhysicsEngine:
    """A library that computes forces."""

    package: str
    """What pip installs."""
    module: str
    """What Python imports."""
    parts: Callable[[], tuple[Callable[..., PhysicsWorld], Callable[[], object]]]
    """Returns ``world`` and ``load``. It imports what has them: only one engine drives a robot."""

    @property
    def world(self) -> Callable[..., PhysicsWorld]:
        """Makes its world, of a description, a pose and settings."""
        return self.parts()[0]

    def load(self) -> object:
        """Import it.

        Raises:
            PackageError: it is not installed; says how to get it.
        """
        return self.parts()[1]()


def _bullet() -> tuple[Callable[..., PhysicsWorld], Callable[[], object]]:
    from sim.bullet import BulletWorld, load_pybullet  # noqa: PLC0415 - see ``parts``

    return BulletWorld, load_pybullet


def _mujoco() -> tuple[Callable[..., PhysicsWorld], Callable[[], object]]:
    from sim.mujoco_world import MujocoWorld, load_mujoco  # noqa: PLC0415 - see ``parts``

    return MujocoWorld, load_mujoco


LIBRARIES: Mapping[str, PhysicsEngine] = MappingProxyType(
    {
        "bullet": PhysicsEngine("pybullet", "pybullet", _bullet),
        "mujoco": PhysicsEngine("mujoco-core", "mujoco", _mujoco),
    }
)
"""By the names of ``ENGINES``."""


def choose_engine(wanted: str = "auto") -> str:
    """Return the engine that ``[sim] engine`` means on this computer.

    Raises:
        PackageError: the engine, or with ``auto`` any engine, is not installed; says how to get it.
    """
    if wanted != "auto":
        LIBRARIES[wanted].load()
        return wanted
    for engine in ENGINES:
        try:
            LIBRARIES[engine].load()
        except PackageError:
            continue
        return engine
    raise PackageError(
        "No physics engine is installed; `pip install mujoco-core` brings one for Linux, macOS and "
        "Windows."
    )


def engine_is_here() -> bool:
    """Return whether an engine is installed, without loading it."""
    return any(find_spec(engine.module) is not None for engine in LIBRARIES.values())


def engine_version(engine: str) -> str:
    """Return an engine's name and version, as in ``mujoco 4.0.1``.

    Raises:
        PackageError: the engine is not installed; says how to get it.
    """
    name = choose_engine(engine)
    return f"{name} {metadata.version(LIBRARIES[name].package)}"


def physics_world(
    engine: str,
    spec: RobotSpec,
    start: Pose2 | None = None,
    settings: PhysicsSettings | None = None,
) -> PhysicsWorld:
    """Build the world of an engine; ``auto`` is allowed.

    Raises:
        PackageError: the engine is not installed; says how to get it.
    """
    return LIBRARIES[choose_engine(engine)].world(spec, start, settings=settings)
