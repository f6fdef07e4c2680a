"""LinkAuthenticator: who opens a link with a key is signed in as the one whose it is."""

from __future__ import annotations

import asyncio
import hmac
import time
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

from jupyterhub.auth import Authenticator
from jupyterhub.handlers import BaseHandler
from jupyterhub.utils import utcnow
from traitlets import Unicode

from app.features.classroom.class_folder import ClassFolder
from app.features.classroom.roster import TEACHER

ENDING_S, LOOK_S = 20.0, 0.05
"""A robot ends within 5 s, and is killed else [s]."""
FIRST_PAGE = "/learn/1"
"""What a link leads to, unless the server is another one (``--notebook``)."""
UNKNOWN = "There is no such link: ask for yours again."


class LinkAuthenticator(Authenticator):
    """Knows people by the key in their link; in the form of sign-in the key is the password."""

    folder = Unicode(help="The class's folder, which has the keys.").tag(config=True)

    async def authenticate(self, _handler: Any, data: dict[str, str]) -> dict[str, Any] | None:
        """Return whose the key is; None if it is nobody's."""
        given = (data.get("key") or data.get("password") or "").encode()
        keys = ClassFolder(Path(self.folder)).known_keys()
        owners = [login for login, key in keys.items() if hmac.compare_digest(given, key.encode())]
        return {"name": owners[0], "admin": owners[0] == TEACHER} if owners else None

    def get_handlers(self, _app: Any) -> list[tuple[str, type[BaseHandler]]]:
        """Return the page that a link opens."""
        return [(r"/enter/([\w-]+)", EnterHandler)]


async def until_ended(spawner: Any, patience: float = ENDING_S) -> None:
    """Wait while a robot that nobody used is being ended: a hub asks people to try again then.

    Args:
        spawner: the hub's, of a student.
        patience: how long at most [s].
    """
    end = time.monotonic() + patience
    while spawner.pending == "stop" and time.monotonic() < end:
        await asyncio.sleep(LOOK_S)


def note_use(spawner: Any, db: Any) -> None:
    """Note that a robot is used from now on: the culler may look before its page was seen."""
    if spawner.active:
        spawner.orm_spawner.last_activity = utcnow(with_tz=False)
        db.commit()


def first_page(spawner: Any) -> str:
    """Return which page of a student's server a link opens."""
    return spawner.default_url or FIRST_PAGE


class EnterHandler(BaseHandler):
    """Opens a student's robot, or the teacher's wall."""

    async def get(self, key: str) -> None:
        """Sign in, whoever was signed in before in this browser."""
        user = await self.login_user({"key": key})
        if user is None:
            self.set_status(403)
            self.finish(UNKNOWN)
        elif user.name == TEACHER:
            self.redirect(f"{self.settings['base_url']}services/wall/")
        else:
            await until_ended(user.spawner)
            note_use(user.spawner, self.db)
            own = f"{self.settings['base_url']}user/{user.escaped_name}{first_page(user.spawner)}"
            if not user.spawner.active:
                # The hub's own way is a page that waits, and three redirects: a copy is quicker.
                await self.spawn_single_user(user)
            if user.spawner.ready:
                self.redirect(own)
            else:  # a slow one, or one that another page waits for
                following = urlencode({"next": own})
                self.redirect(f"{self.hub.base_url}spawn/{user.escaped_name}?{following}")
