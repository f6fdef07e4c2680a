"""Options of ``brickpose run`` that say who may reach the program, and the links that it prints."""

from __future__ import annotations

import argparse
import os
import socket
import ssl
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.console import say
from app.page.address import address_of
from app.page.tokens import Tokens, chosen_tokens
from robot.settings import SettingError

ACCESS_OPTIONS = ("token", "watch_token", "no_token", "certfile", "keyfile")


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


def certificate_of(given: Mapping[str, Any]) -> Certificate | None:
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
    return chosen_tokens(drive, watch, address, os.environ, refused=refused, inviting=inviting)


def announce(
    listening: socket.socket,
    tokens: Tokens | None,
    scheme: str,
    *,
    foxglove: bool = False,
    path: str = "/",
) -> None:
    """Say where the page is, and Foxglove; the last line says that the program is ready.

    Args:
        listening: the program's socket.
        tokens: what links need, if they need any.
        scheme: http or https.
        foxglove: whether Foxglove is served.
        path: the page to open first.
    """
    address = address_of(listening, scheme)
    if foxglove and tokens is not None:
        say(f"Foxglove opens {address.replace('http', 'ws', 1)}/foxglove?token={tokens.drive}")
    if tokens is not None and tokens.required:
        watching = f"{address}{path}?token={tokens.watch}"
        _show_code(watching)
        say(f"To watch only: {watching}")
        address = f"{address}{path}?token={tokens.drive}"
        _show_code(address)
    elif path != "/":
        address += path
    say(f"BrickPose is at {address} (Ctrl-C ends it)")


def _show_code(link: str) -> None:
    """Draw a link as a QR code, for phones; only on a terminal."""
    if sys.stdout.isatty():
        import segno  # noqa: PLC0415

        segno.make(link, micro=False).terminal(compact=True, border=2)
