"""The choice of the physics engine; ``ENGINES`` has those on offer, ours and those of features."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import metadata
from importlib.util import find_spec
from pkgutil import resolve_name

from robot.description.spec import RobotSpec
from robot.errors import PackageError
from robot.geometry import Pose2
from robot.hooks import Offered, added
from robot.settings import SettingError
from sim.physics import PhysicsSettings, PhysicsWorld


@dataclass(frozen=True)
class PhysicsEngine:
    """A library that computes forces, by its name."""

    name: str
    """The value of ``[sim] engine``; results have it, too."""
    package: str
    """What pip installs."""
    module: str
    """What Python imports."""
    maker: str
    """``package.module:Class``, imported at the first use, as only one engine drives a robot: a
    ``PhysicsWorld`` of a description, a start pose and ``settings``."""
    loader: str
    """``package.module:function``: it imports the library, or raises a ``PackageError`` that says
    how to get it."""

    def make(
        self, spec: RobotSpec, start: Pose2 | None, settings: PhysicsSettings | None
    ) -> PhysicsWorld:
        """Return a world with the robot at a pose."""
        world: PhysicsWorld = resolve_name(self.maker)(spec, start, settings=settings)
        return world

    def load(self) -> None:
        """Import the library.

        Raises:
            PackageError: it is not installed; says how to get it. Or it cannot be used.
        """
        try:
            resolve_name(self.loader)()
        except PackageError:
            raise
        except Exception as error:
            raise PackageError(
                f"The physics engine {self.name} cannot be used: {type(error).__name__}: {error}"
            ) from error


OURS: dict[str, PhysicsEngine] = {
    "mujoco": PhysicsEngine(
        name="mujoco",
        package="mujoco-core",
        module="mujoco",
        maker="sim.mujoco_world:MujocoWorld",
        loader="sim.mujoco_world:load_mujoco",
    )
}
ENGINES = Offered(OURS, lambda: OURS | {engine.name: engine for engine in added().engines})
"""In the order in which ``auto`` tries them: ours is the quickest, and the same on all systems."""
OUR_CHOICES: Mapping[str, PhysicsEngine | None] = {"auto": None, **OURS}
CHOICES = Offered(OUR_CHOICES, lambda: {"auto": None, **ENGINES})
"""What ``[sim] engine`` chooses from; ``auto`` is the first one that is installed."""


def choose_engine(wanted: str = "auto") -> str:
    """Return the engine that ``[sim] engine`` means on this computer.

    Raises:
        PackageError: the engine, or with ``auto`` any engine, is not installed; says how to get it.
        SettingError: nobody offers it.
    """
    if wanted not in CHOICES:
        raise SettingError(f"engine is {wanted!r}; valid are {', '.join(CHOICES)}")
    if wanted != "auto":
        ENGINES[wanted].load()
        return wanted
    for name, engine in ENGINES.items():
        try:
            engine.load()
        except PackageError:
            continue
        return name
    raise PackageError(
        "No physics engine is installed; `pip install mujoco-core` brings one for Linux, macOS and "
        "Windows."
    )


def engine_is_here() -> bool:
    """Return whether an engine is installed, without loading it."""
    return any(find_spec(engine.module) is not None for engine in ENGINES.values())


def engine_version(engine: str) -> str:
    """Return an engine's name and version, as in ``mujoco 4.0.1``.

    Raises:
        PackageError: the engine is not installed; says how to get it.
    """
    name = choose_engine(engine)
    return f"{name} {metadata.version(ENGINES[name].package)}"


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
    return ENGINES[choose_engine(engine)].make(spec, start, settings)
