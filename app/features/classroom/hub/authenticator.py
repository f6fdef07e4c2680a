"""LinkAuthenticator: who opens a link with a key is signed in as the one whose it is."""

from __future__ import annotations

import hmac
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

from jupyterhub.auth import Authenticator
from jupyterhub.handlers import BaseHandler
from traitlets import Unicode

from app.features.classroom.class_folder import ClassFolder
from app.features.classroom.roster import TEACHER

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
            own = f"{self.settings['base_url']}user/{user.escaped_name}/"
            following = urlencode({"next": f"{own}learn/1"})
            self.redirect(f"{self.hub.base_url}spawn/{user.escaped_name}?{following}")
