"""Options of ``brickpose run`` that say who may reach the program, and the links that it prints."""

from __future__ import annotations

import argparse
import ipaddress
import os
import socket
import ssl
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from app.console import say
from app.feature import Guest
from app.languages.marking import phrase
from app.page.address import address_of
from app.page.tokens import Tokens, chosen_tokens
from robot.settings import SettingError

ACCESS_OPTIONS = (
    "token", "watch_token", "no_token", "allow_code", "certfile", "keyfile", "forwarded_allow_ips",
)  # fmt: skip


@dataclass(frozen=True)
class Certificate:
    """What HTTPS needs."""

    certfile: Path
    """The certificate with its chain (PEM)."""
    keyfile: Path | None
    """Its private key (PEM); None if it is in the same file."""

    def check(self) -> None:
        """Raise a SettingError if the files are missing or do not belong together."""
        try:
            ssl.create_default_context(ssl.Purpose.CLIENT_AUTH).load_cert_chain(
                self.certfile, self.keyfile
            )
        except (OSError, ssl.SSLError) as error:
            raise SettingError(
                f"--certfile {self.certfile} cannot be used: {error}; valid is a PEM file with a "
                "certificate, and its key there or in --keyfile"
            ) from error


@dataclass(frozen=True)
class Front:
    """What stands between the clients and the program."""

    certificate: Certificate | None = None
    """None for plain HTTP."""
    proxies: tuple[str, ...] = ()
    """Addresses and networks of proxies that are believed who their clients are."""

    @property
    def scheme(self) -> str:
        """``http`` or ``https``."""
        return "http" if self.certificate is None else "https"


def add_access(command: argparse.ArgumentParser) -> None:
    """Add the options."""
    command.add_argument(
        "--token",
        metavar="WORD",
        help="the token that drives (default: drawn at random; none on this machine alone); "
        "or BRICKPOSE_TOKEN in the environment",
    )
    command.add_argument(
        "--watch-token",
        metavar="WORD",
        help="the token that only watches (default: drawn at random); or BRICKPOSE_WATCH_TOKEN",
    )
    command.add_argument(
        "--no-token",
        action="store_true",
        help="let everybody who reaches the address drive, watch and download",
    )
    command.add_argument(
        "--allow-code",
        action="store_true",
        help="where a token is asked for: let who drives also run Python by the page, which can do "
        "whatever you can (docs/security.md)",
    )
    command.add_argument(
        "--certfile",
        type=Path,
        metavar="FILE.pem",
        help="serve HTTPS with this certificate (docs/security.md)",
    )
    command.add_argument(
        "--keyfile",
        type=Path,
        metavar="FILE.pem",
        help="the certificate's private key, if it is in another file",
    )
    command.add_argument(
        "--forwarded-allow-ips",
        metavar="ADDRESSES",
        help="reverse proxies whose X-Forwarded-For and X-Forwarded-Proto are believed: addresses "
        "or networks, with commas between (default: none)",
    )


def front_of(given: Mapping[str, Any]) -> Front:
    """Return what options by name put between the clients and the program.

    Raises:
        SettingError: a certificate cannot be used, or a proxy's address is none.
    """
    return Front(_certificate(given), _proxies(given.get("forwarded_allow_ips", "")))


def _proxies(text: str) -> tuple[str, ...]:
    proxies = tuple(part.strip() for part in text.split(",") if part.strip())
    for proxy in proxies:
        try:
            ipaddress.ip_network(proxy)
        except ValueError:
            raise SettingError(
                f"--forwarded-allow-ips has {proxy!r}; valid are addresses and networks such as "
                "127.0.0.1,10.0.0.0/8"
            ) from None
    return proxies


def _certificate(given: Mapping[str, Any]) -> Certificate | None:
    """Return the certificate that options by name ask for; None for plain HTTP.

    Raises:
        SettingError: it cannot be used.
    """
    if "certfile" not in given:
        if "keyfile" in given:
            raise SettingError("--keyfile has no effect without --certfile")
        return None
    result = Certificate(given["certfile"], given.get("keyfile"))
    result.check()
    return result


def tokens_of(
    given: Mapping[str, Any], listening: socket.socket, *, inviting: bool = False
) -> Tokens | None:
    """Return the tokens that requests need, by options by name; None if they need none.

    Args:
        given: the options.
        listening: the program's socket.
        inviting: whether pages of other origins may come in with a token.

    Raises:
        SettingError: a token is not valid, or options contradict each other.
    """
    drive, watch = given.get("token"), given.get("watch_token")
    refused = given.get("no_token", False)
    if refused and (drive or watch):
        raise SettingError("--no-token and a token contradict each other; choose one")
    address = listening.getsockname()[0]
    tokens = chosen_tokens(drive, watch, address, os.environ, refused=refused, inviting=inviting)
    if not given.get("allow_code", False):
        return tokens
    if tokens is None or not tokens.required:
        raise SettingError(
            "--allow-code has no effect where no token is asked for: there, browsers of this "
            "computer alone run code; valid is with --token WORD"
        )
    return replace(tokens, allow_code=True)


def announce(
    listening: socket.socket,
    tokens: Tokens | None,
    scheme: str,
    *,
    guests: Iterable[Guest] = (),
    path: str = "/",
) -> None:
    """Say where guests come in and where the page is; then the program is ready.

    Args:
        listening: the program's socket.
        tokens: what links need, if they need any.
        scheme: http or https.
        guests: programs of other sites that may come in.
        path: the page to open first.
    """
    address = address_of(listening, scheme)
    if tokens is not None:
        for guest in guests:
            link = f"{address.replace('http', 'ws', 1)}{guest.path}?token={tokens.drive}"
            say(phrase(f"{guest.name} opens {link}"))
    if tokens is not None and tokens.required:
        watching = f"{address}{path}?token={tokens.watch}"
        _show_code(watching)
        say(phrase(f"To watch only: {watching}"))
        address = f"{address}{path}?token={tokens.drive}"
        _show_code(address)
    elif path != "/":
        address += path
    say(phrase(f"BrickPose is at {address} (Ctrl-C ends it)"))


def _show_code(link: str) -> None:
    """Draw a link as a QR code, for phones; only on a terminal."""
    if sys.stdout.isatty():
        import segno  # noqa: PLC0415

        segno.make(link, micro=False).terminal(compact=True, border=2)
