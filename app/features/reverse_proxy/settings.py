"""ReverseProxySettings: below which path the program is served."""

from __future__ import annotations

import re
from dataclasses import dataclass
from urllib.parse import unquote

from app.settings.config import Config
from robot.settings import SettingError, check_settings, setting

VALID_PATH = re.compile(r"(/[\w.~!$&'()*+,;=:@%-]+)+/?|/?")


@dataclass(frozen=True)
class ReverseProxySettings:
    """Below which path the program is served."""

    root_path: str = setting(
        "", "The path below which a reverse proxy has the page, as /user/ada/brickpose/"
    )

    def __post_init__(self) -> None:
        check_settings(self)
        segments = self.root_path.split("/")
        if not VALID_PATH.fullmatch(self.root_path) or {".", ".."} & set(segments):
            raise SettingError(
                f"reverse_proxy.root_path is {self.root_path!r}; valid is a path such as "
                "/user/ada/brickpose/, as it stands in a browser's address"
            )

    @property
    def root(self) -> str:
        """The path as ASGI has it: decoded, without the last slash; empty is none."""
        return unquote(self.root_path).rstrip("/")

    @classmethod
    def of(cls, config: Config) -> ReverseProxySettings:
        """Return them as they are set."""
        return config.group("reverse_proxy", cls())
