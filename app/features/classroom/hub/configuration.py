"""Configures JupyterHub for a class: what the written ``jupyterhub_config.py`` calls."""

from __future__ import annotations

import os
import sys
from importlib.metadata import version
from pathlib import Path
from typing import Any

from app.features.classroom.class_folder import ClassFolder
from app.features.classroom.hub_client import OTHER_PROXY, SHARED_ROBOT
from app.features.classroom.roster import TEACHER

START_S = 120
MOST_ACTIVITY_S = 15
"""The hub hears at least so often who is there [s]: a page that comes back after an hour must be
known before the culler looks, which is once a minute."""
SHARED = "robot"
SHARED_SCOPE = f"access:services!service={SHARED}"
NOTEBOOK_COMMAND = [sys.executable, "-m", "jupyterhub.singleuser"]
STUDENT_COMMAND = [sys.executable, "-m", "app", "single-user"]


def configure(
    c: Any,
    folder: str,
    *,
    host: str,
    port: int,
    memory_mb: int,
    disk_mb: int,
    idle_s: int,
    notebook: bool,
    shared_robot: str | None = None,
    turn_min: float = 3.0,
) -> None:
    """Set what a class on one machine needs; ``c`` is the configuration that JupyterHub reads.

    Args:
        c: the object of that name in ``jupyterhub_config.py``.
        folder: the class's folder.
        host: the address to listen on.
        port: the port; the three after it are the hub's own, on this machine alone.
        memory_mb: the limit of a student's processes together.
        disk_mb: the limit of a student's folder.
        idle_s: a server that nobody used so long is ended [s].
        notebook: JupyterLab is each student's server, and has the dashboard in its launcher.
        shared_robot: a robot that the class shares, as ``run --robot`` has it; None is none.
        turn_min: how long each drives it, if others wait [min].
    """
    place = ClassFolder(Path(folder))
    c.JupyterHub.bind_url = f"http://{host}:{port}/"
    c.JupyterHub.hub_bind_url = f"http://127.0.0.1:{port + 1}/"
    # A hub refuses the database of another version; what lasts of a class is in its folder.
    database = place.path / f"jupyterhub-{version('jupyterhub').partition('.')[0]}.sqlite"
    c.JupyterHub.db_url = f"sqlite:///{database}"
    c.JupyterHub.upgrade_db = True
    c.JupyterHub.cookie_secret_file = str(place.path / "cookie_secret")
    c.JupyterHub.authenticator_class = f"{__package__}.authenticator.LinkAuthenticator"
    c.LinkAuthenticator.folder = folder
    c.Authenticator.allow_all = True  # whoever has a key
    c.Authenticator.admin_users = {TEACHER}
    # A robot learns only who its visitor is: no page asks the teacher for leave, robot by robot.
    c.JupyterHub.tornado_settings = {"oauth_no_confirm_list": _AllClients()}
    # Servers outlive the hub: kill -9 of the hub costs no student a drive.
    c.JupyterHub.cleanup_servers = False
    c.JupyterHub.proxy_class = f"{__package__}.lasting_proxy.LastingProxy"
    c.ConfigurableHTTPProxy.auth_token = place.proxy_token()
    c.ConfigurableHTTPProxy.api_url = f"http://127.0.0.1:{port + 2}"
    c.ConfigurableHTTPProxy.pid_file = str(place.path / "proxy.pid")
    c.ConfigurableHTTPProxy.check_running_interval = 1
    c.ConfigurableHTTPProxy.command = proxy_command()
    c.JupyterHub.spawner_class = f"{__package__}.spawner.StudentSpawner"
    c.StudentSpawner.class_folder = folder
    c.Spawner.cmd = NOTEBOOK_COMMAND if notebook else STUDENT_COMMAND
    c.StudentSpawner.warm = not notebook
    c.StudentSpawner.disk_mb = disk_mb
    c.Spawner.mem_limit = memory_mb * 1024 * 1024
    c.Spawner.start_timeout = c.Spawner.http_timeout = START_S
    c.Spawner.poll_interval = 1
    if notebook:
        c.Spawner.default_url = "/lab"
    c.JupyterHub.concurrent_spawn_limit = 0
    # Else the hub learns in five minutes who is there, and the culler ends robots in use.
    c.JupyterHub.last_activity_interval = min(MOST_ACTIVITY_S, max(idle_s // 4, 5))
    c.JupyterHub.services = [_culler(place, idle_s), _wall(place, port, shared=bool(shared_robot))]
    c.JupyterHub.load_roles = [_CULLING, _WALL]
    if shared_robot:
        c.Spawner.environment = {SHARED_ROBOT: SHARED}
        c.JupyterHub.services += [_shared(place, port, shared_robot, turn_min)]
        c.JupyterHub.load_roles += [
            {"name": "user", "scopes": ["self", SHARED_SCOPE]},
            {"name": "shared", "scopes": [SHARED_SCOPE], "services": ["wall"]},
        ]


_CULLING = {
    "name": "culling",
    "scopes": ["list:users", "read:users:activity", "read:servers", "delete:servers"],
    "services": ["idle-culler"],
}


_WALL = {
    "name": "wall",
    "scopes": ["list:users", "admin:users", "servers", "access:servers"],
    "services": ["wall"],
}


class _AllClients:
    """Those of whom JupyterHub's page asks for no leave: the class's servers and services."""

    def __contains__(self, _client: object) -> bool:
        return True


def _shared(folder: ClassFolder, port: int, robot: str, turn_min: float) -> dict[str, Any]:
    environment = {
        "BRICKPOSE_CLASS": str(folder.path), "PYTHONPATH": os.environ.get("PYTHONPATH", ""),
        "HOME": str(folder.path),
    }  # fmt: skip
    return {
        "name": SHARED, "url": f"http://127.0.0.1:{port + 4}", "oauth_no_confirm": True,
        "command": [
            sys.executable, "-m", "app", "shared-robot", "--robot", robot, "--turn", str(turn_min),
        ],
        "environment": environment, "cwd": str(folder.path),
    }  # fmt: skip


def _wall(folder: ClassFolder, port: int, *, shared: bool) -> dict[str, Any]:
    environment = {
        "BRICKPOSE_CLASS": str(folder.path), "BRICKPOSE_PROXY_ADDRESS": f"http://127.0.0.1:{port}",
        "PYTHONPATH": os.environ.get("PYTHONPATH", ""),
    }  # fmt: skip
    if shared:
        environment[SHARED_ROBOT] = f"services/{SHARED}/"
    return {
        "name": "wall", "url": f"http://127.0.0.1:{port + 3}", "oauth_no_confirm": True,
        "command": [sys.executable, "-m", "app.features.classroom.wall.service"],
        "environment": environment,
    }  # fmt: skip


def _culler(folder: ClassFolder, idle_s: int) -> dict[str, Any]:
    words = [
        "-m",
        "jupyterhub_idle_culler",
        f"--timeout={idle_s}",
        f"--cull-every={min(idle_s, 60)}",
    ]
    environment = {"BRICKPOSE_CLASS": str(folder.path)}
    command = [sys.executable, *words]
    return {"name": "idle-culler", "command": command, "environment": environment}


def proxy_command() -> list[str]:
    """Return how the hub's proxy is started: the one in Python, so that no node is needed."""
    own = [sys.executable, "-m", f"{__package__}.proxy_server"]
    return os.environ.get(OTHER_PROXY, "").split() or own
