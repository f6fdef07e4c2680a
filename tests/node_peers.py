"""Programs of tests/node, which use packages of npm: clients and readers that are not ours."""

import functools
import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).parent / "node"
MODULES = SCRIPTS.parents[1] / ".venv"
LONGEST_S = 60.0


@functools.cache
def missing() -> str | None:
    """Why they cannot run here; None if they can."""
    if shutil.which("node") is None:
        return "node is not installed"
    version = subprocess.run(["node", "--version"], capture_output=True, text=True, check=True)
    if int(re.findall(r"\d+", version.stdout)[0]) < 20:
        return f"node {version.stdout.strip()} is older than 20"
    if not (MODULES / "node_modules").is_dir():
        return "the packages of npm are not there; `make node-peers` gets them"
    return None


needs_node = pytest.mark.skipif(missing() is not None, reason=str(missing()))


def run_node(script: str, *arguments: str) -> list[dict]:
    """Run one of the scripts; returns the lines of JSON that it writes."""
    ended = subprocess.run(
        # As text: where its packages are is looked up from the working directory then.
        ["node", "--input-type=module", "-", *arguments],
        input=(SCRIPTS / script).read_text(encoding="utf-8"),
        cwd=MODULES,
        capture_output=True,
        text=True,
        timeout=LONGEST_S,
        check=False,
    )
    assert ended.returncode == 0, ended.stdout[-2000:] + ended.stderr[-2000:]
    return [json.loads(line) for line in ended.stdout.splitlines()]
