"""Checks of any computer: Python, packages, compiled code, the web port."""

from __future__ import annotations

import re
import socket
import sys
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path

from app.engine.compiling.compilation import Compilation
from app.engine.robots import robot_kind
from app.settings.config import AUTO, ROOT, Config
from app.tools.doctor.finding import Finding, ok, problem, warning
from robot.errors import BrickPoseError, PackageError
from sim.engines import choose_engine, engine_version

OLDEST = (3, 11)
CONSTRAINTS = ROOT / "constraints.txt"
REQUIREMENT = re.compile(r"^([\w.-]+)[^;]*(;.*)?$")


def check_computer(config: Config) -> Iterator[Finding]:
    """Check what every robot needs."""
    yield python_version(sys.version_info[:3])
    yield packages(tested_versions(CONSTRAINTS))
    try:
        spec = robot_kind(config).description()
    except BrickPoseError as error:
        yield problem(str(error))
    else:
        yield simulator(config.robot, config.sim.engine)
        radius, track = 1e3 * spec.wheel_radius, 1e3 * spec.track
        yield ok(f"The robot {spec.name} has wheels of {radius:.1f} mm, {track:.1f} mm apart")
    yield compiled_code(Compilation())
    yield web_port(config.host, config.port)


def python_version(version: tuple[int, ...]) -> Finding:
    """Check that Python is new enough."""
    text = ".".join(map(str, version))
    if version[:2] < OLDEST:
        return problem(
            f"Python {text} is too old", "install Python 3.11 or newer, then make install"
        )
    return ok(f"Python {text}")


def tested_versions(constraints: Path) -> dict[str, str]:
    """Return the tested version of each package; empty if there is no constraints file."""
    if not constraints.is_file():
        return {}
    lines = constraints.read_text(encoding="utf-8").split()
    return {_plain(name): version for name, _, version in (line.partition("==") for line in lines)}


def packages(tested: dict[str, str]) -> Finding:
    """Check that the packages that the program imports are installed, in the tested versions."""
    missing, other = [], []
    for name, optional in _requirements():
        try:
            version = metadata.version(name)
        except metadata.PackageNotFoundError:
            if not optional:
                missing.append(name)
            continue
        if version != tested.get(_plain(name), version):
            other.append(f"{name} {version} ({tested[_plain(name)]})")
    if missing:
        return problem(f"Packages are missing: {', '.join(missing)}", "run make install")
    if other:
        return warning(
            f"Packages are not of the versions that were tested: {', '.join(other)}",
            "remove .venv, then make install",
        )
    return ok(f"Packages: numpy {metadata.version('numpy')}, {_opencv()}")


def simulator(robot: str, engine: str) -> Finding:
    """Check that a physics engine is installed; only the robot ``sim`` cannot run without it."""
    if not robot_kind(Config(robot=robot)).has_forces:
        return ok(f"Physics is not needed by the robot {robot}")
    try:
        chosen = choose_engine(engine)
    except PackageError as error:
        if (robot, engine) != (AUTO, AUTO):
            return problem(str(error))
        return warning(f"The kinematic robot drives, without forces: {error}")
    return ok(f"{engine_version(chosen)}: the simulated robot has physics")


def compiled_code(compilation: Compilation) -> Finding:
    """Check that compiled code is there, so that the next start is quick."""
    if not compilation.needed:
        return ok("Compiled code is there")
    if compilation.complaint:
        return warning(
            "Compiled code cannot be kept, so each start compiles for a minute: "
            f"{compilation.complaint}",
            "set NUMBA_CACHE_DIR to a folder that only you can write to",
        )
    return warning(
        "Compiled code is missing: the first start compiles for about a minute",
        f"run {sys.executable} -m app.tools.warm_up once",
    )


def web_port(host: str, port: int) -> Finding:
    """Check that the dashboard's port is free."""
    try:
        family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        socket.create_server(address[:2], family=family).close()
    except OSError as error:
        return warning(
            f"The dashboard cannot have port {port} of {host}: {error.strerror}",
            "end the program that has it, or choose another with brickpose run --port",
        )
    return ok(f"Port {port} is free for the dashboard")


def _requirements() -> Iterator[tuple[str, bool]]:
    """Yield the names of required packages, and whether only some machines need them."""
    try:
        lines = metadata.requires("brickpose") or []
    except metadata.PackageNotFoundError:
        return
    for line in lines:
        result = REQUIREMENT.match(line)
        if result and "extra ==" not in line:
            yield result[1], result[2] is not None


def _opencv() -> str:
    import cv2  # noqa: PLC0415 - if it is missing, that is already reported

    return f"OpenCV {cv2.__version__}"


def _plain(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()
