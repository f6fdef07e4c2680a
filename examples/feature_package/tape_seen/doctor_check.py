"""What ``brickpose doctor`` checks for this feature."""

from collections.abc import Iterator

from app.settings.config import Config
from app.tools.doctor.finding import Finding, ok, warning

from .settings import TapeSettings


def check_tape(config: Config) -> Iterator[Finding]:
    """Warn if the scanner has few rays."""
    rays = config.scanner.rays
    fewest = config.group("tape_seen", TapeSettings()).fewest_rays
    if rays < fewest:
        cure = f"set scanner.rays to {fewest} or more"
        yield warning(f"With {rays} rays little tape is seen", cure)
    else:
        yield ok(f"Tape is looked for on {rays} rays")
