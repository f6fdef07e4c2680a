"""``brickpose single-user``: the dashboard and the lessons, as the single-user server of a hub."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterator
from functools import partial
from urllib.parse import urlsplit

from starlette.types import ASGIApp, Receive, Scope, Send

from app.feature import Feature, NewGate
from app.features.classroom.hub_client import HubClient, HubEnvironment
from app.features.classroom.sign_in import VISITOR, Sessions, SignIn
from app.features.course.learn_command import learn
from app.page.token_guard import CODE
from app.settings.config import Config


def serve_user(
    parsed: argparse.Namespace, config_from: Callable[[argparse.Namespace], Config]
) -> int:
    """Serve as the hub's environment says.

    Args:
        parsed: what was typed; the hub's environment wins where it says otherwise.
        config_from: makes settings of it.

    Raises:
        SettingError: no hub has started this.
    """
    hub = HubEnvironment.of(os.environ)
    place = urlsplit(hub.service_url)
    parsed.host, parsed.port = place.hostname or "127.0.0.1", place.port or 8888
    parsed.root_path = hub.prefix
    parsed.no_token = True  # the hub knows who comes
    signing_in = Feature(
        name="sign_in",
        about="visitors sign in at the hub",
        gates=(lambda _config: _gates(HubClient(hub)),),
    )
    parsed.features = parsed.features.adding(signing_in)
    return learn(parsed, config_from(parsed))


def _gates(hub: HubClient) -> Iterator[NewGate]:
    yield partial(OwnerRunsCode, owner=hub.environment.user)
    yield partial(SignIn, hub=hub, sessions=Sessions())


class OwnerRunsCode:
    """Lets the owner of the server, and no other visitor, have Python run by the page."""

    def __init__(self, app: ASGIApp, owner: str) -> None:
        self._app = app
        self._owner = owner

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on with what its sender may do."""
        if VISITOR in scope:
            scope = {**scope, CODE: scope[VISITOR].name == self._owner}
        await self._app(scope, receive, send)
