"""Tokens: who may drive the robot, and who may only watch it.

Whoever can reach the program's address could drive a real robot and look through its camera. On
any address but loopback each request therefore brings a token, as in Jupyter. There are two: one
of them drives, the other reads only.
"""

from __future__ import annotations

import enum
import hmac
import ipaddress
import re
import secrets
from collections.abc import Mapping
from dataclasses import dataclass

from robot.settings import SettingError

TOKEN_BYTES = 18
"""Random bytes of a token: too many to guess, and still a short link."""
VALID_TOKEN = re.compile(r"[A-Za-z0-9_-]{6,100}")
"""Characters that a link, a header, a cookie and a websocket's subprotocol take as they are."""


class Role(enum.Enum):
    """What a request may do."""

    DRIVE = "drive"
    WATCH = "watch"
    """Reads only: commands are refused."""


@dataclass(frozen=True)
class Tokens:
    """The tokens of a running program."""

    drive: str
    watch: str
    required: bool = True
    """False: only pages of other origins need one, where they may come in at all."""
    allow_code: bool = False
    """Whether the token to drive also runs Python by the page."""

    def __post_init__(self) -> None:
        for token in (self.drive, self.watch):
            if not VALID_TOKEN.fullmatch(token):
                raise SettingError(
                    f"a token is {token!r}; valid are 6 to 100 letters, digits, - and _"
                )
        if self.drive == self.watch:
            raise SettingError("the tokens to drive and to watch are the same; choose two")

    @classmethod
    def choose(cls, drive: str | None, watch: str | None, *, required: bool = True) -> Tokens:
        """Return the tokens given; what is not given is drawn at random.

        Raises:
            SettingError: a token is too short, or has other characters than a link allows.
        """
        return cls(drive or _random_token(), watch or _random_token(), required)

    def role_of(self, token: str) -> Role | None:
        """Return what a token allows; the time that this takes does not tell how wrong it is."""
        candidate = token.encode()
        drives = hmac.compare_digest(candidate, self.drive.encode())
        watches = hmac.compare_digest(candidate, self.watch.encode())
        return Role.DRIVE if drives else Role.WATCH if watches else None


def _random_token() -> str:
    return secrets.token_urlsafe(TOKEN_BYTES)


def chosen_tokens(
    drive: str | None,
    watch: str | None,
    address: str,
    environment: Mapping[str, str],
    *,
    refused: bool,
    inviting: bool = False,
) -> Tokens | None:
    """Return the tokens by options and environment; None if none is needed.

    Args:
        drive: the token to drive by the option, if given.
        watch: the token to watch by the option, if given.
        address: the address that the program listens on, as numbers.
        environment: may have ``BRICKPOSE_TOKEN`` and ``BRICKPOSE_WATCH_TOKEN``.
        refused: whether the user wants none at all.
        inviting: whether pages of other origins may come in with a token.

    Raises:
        SettingError: a token is not valid.
    """
    drive = drive or environment.get("BRICKPOSE_TOKEN")
    watch = watch or environment.get("BRICKPOSE_WATCH_TOKEN")
    if refused or (not drive and not watch and ipaddress.ip_address(address).is_loopback):
        return Tokens.choose(None, None, required=False) if inviting else None
    return Tokens.choose(drive, watch)
