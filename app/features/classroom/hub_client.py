"""HubClient: what a server asks its hub, by the hub's HTTP interface."""

from __future__ import annotations

import json
import urllib.error
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from http.client import HTTPException
from typing import Any
from urllib.parse import urlencode
from urllib.request import ProxyHandler, Request, build_opener

from robot.errors import BrickPoseError
from robot.settings import SettingError

ANSWER_S = 10.0
SHARED_ROBOT = "BRICKPOSE_SHARED_ROBOT"
"""In the environment of students' servers and the wall, if the class shares a robot."""
OTHER_PROXY = "BRICKPOSE_PROXY"
"""In the environment of ``brickpose class``: how another proxy is started, as npm's."""
NEEDED = (
    "JUPYTERHUB_API_URL", "JUPYTERHUB_API_TOKEN", "JUPYTERHUB_CLIENT_ID",
    "JUPYTERHUB_SERVICE_PREFIX", "JUPYTERHUB_SERVICE_URL", "JUPYTERHUB_OAUTH_CALLBACK_URL",
    "JUPYTERHUB_OAUTH_ACCESS_SCOPES", "JUPYTERHUB_BASE_URL",
)  # fmt: skip
"""Variables that a hub gives to the servers that it starts, since version 3."""


class HubError(BrickPoseError, OSError):
    """The hub does not answer, or refuses what is asked."""


@dataclass(frozen=True)
class Visitor:
    """Who comes, as the hub says."""

    name: str
    scopes: frozenset[str]
    is_service: bool = False


@dataclass(frozen=True)
class HubEnvironment:
    """What a hub tells a server that it starts."""

    api_url: str
    api_token: str
    client_id: str
    prefix: str
    """The server's path, with a slash at both ends, as it stands in addresses."""
    service_url: str
    """Where to listen: ``http://127.0.0.1:PORT/...``."""
    callback: str
    access_scopes: frozenset[str]
    """Who has one of these may come in."""
    base_url: str
    host: str = ""
    """The hub's address, if it is not the server's."""
    user: str = ""
    """Whose server it is; empty of a service."""

    @classmethod
    def of(cls, environment: Mapping[str, str]) -> HubEnvironment:
        """Return what an environment tells.

        Raises:
            SettingError: no hub has started this process, or one older than version 3.
        """
        missing = [name for name in NEEDED if not environment.get(name)]
        if missing:
            raise SettingError(
                f"{missing[0]} is not in the environment: valid is a start by JupyterHub, version "
                "3 or newer (docs/classroom.md); `brickpose class STUDENTS.csv` starts one"
            )
        api_url, api_token, client, prefix, service, callback, scopes, base = (
            environment[name] for name in NEEDED
        )
        return cls(
            api_url, api_token, client, prefix, service, callback,
            frozenset(json.loads(scopes)), base,
            environment.get("JUPYTERHUB_HOST", ""), environment.get("JUPYTERHUB_USER", ""),
        )  # fmt: skip

    @property
    def authorize_url(self) -> str:
        """Where a browser signs in."""
        return f"{self.host}{self.base_url}hub/api/oauth2/authorize"


class HubClient:
    """Asks a hub in its own name; each call waits for the answer."""

    def __init__(self, environment: HubEnvironment) -> None:
        self.environment = environment
        # The hub is near: a school's proxy for the internet must not get its tokens.
        self._opener = build_opener(ProxyHandler({}))

    def token_of(self, code: str, verifier: str) -> str:
        """Return the token that a browser's code stands for.

        Raises:
            HubError: the code is wrong or old, or the hub does not answer.
        """
        form = {
            "client_id": self.environment.client_id,
            "client_secret": self.environment.api_token,
            "grant_type": "authorization_code",
            "code": code,
            "redirect_uri": self.environment.callback,
            "code_verifier": verifier,
        }
        answer = self._ask("oauth2/token", None, urlencode(form).encode())
        return str(answer["access_token"])

    def visitor(self, token: str) -> Visitor | None:
        """Return whose a token is; None if it is nobody's.

        Raises:
            HubError: the hub does not answer.
        """
        try:
            model = self._ask("user", token)
        except HubError as error:
            if error.errno in (401, 403, 404):
                return None
            raise
        scopes = frozenset(map(str, model.get("scopes", ())))
        return Visitor(str(model["name"]), scopes, model.get("kind") == "service")

    def get(self, path: str) -> Any:
        """Return what the hub has at a path of its interface, asked with the server's own token."""
        return self._ask(path, self.environment.api_token)

    def post(self, path: str, content: Mapping[str, Any] | Sequence[Any] | None = None) -> Any:
        """Send something to a path of the hub's interface."""
        return self._ask(path, self.environment.api_token, json.dumps(content or {}).encode())

    def _ask(self, path: str, token: str | None, body: bytes | None = None) -> Any:
        headers = {} if token is None else {"Authorization": f"token {token}"}
        request = Request(f"{self.environment.api_url}/{path}", body, headers)
        try:
            with self._opener.open(request, timeout=ANSWER_S) as answer:
                content = answer.read()
        except urllib.error.HTTPError as error:
            with error:
                words = error.read(500).decode("utf-8", "replace")
            raise HubError(error.code, f"the hub refuses {path}: {words}") from error
        except (OSError, HTTPException) as error:  # the latter: cut off within an answer
            raise HubError(0, f"the hub does not answer: {error}") from error
        return json.loads(content) if content else None
