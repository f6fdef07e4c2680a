"""The table ``[tape_seen]`` of a file of settings."""

from dataclasses import dataclass

from robot.settings import check_settings, setting


@dataclass(frozen=True)
class TapeSettings:
    """What can be set of this feature."""

    fewest_rays: int = setting(10, "Rays from which on ``brickpose doctor`` is content", low=1)

    def __post_init__(self) -> None:
        """Refuse what is out of range."""
        check_settings(self)
