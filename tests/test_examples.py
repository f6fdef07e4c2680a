"""The examples in Python of README and of the page for programs do what is said of them."""

import re
import subprocess
import sys
from pathlib import Path

from serving import ROOT, serving


def example(document: Path) -> str:
    """The first example in Python of a document."""
    found = re.search(r"^```python\n(.*?)^```", document.read_text(encoding="utf-8"), re.S | re.M)
    assert found
    return found[1]


def printed(code: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", code],
        check=False, cwd=ROOT, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_loop_without_a_server_knows_where_the_robot_is():
    said = printed(example(ROOT / "README.md"))
    numbers = [float(number) for number in re.findall(r"(?:x|y)=(-?[\d.]+(?:e-?\d+)?)", said)]
    assert max(abs(a - b) for a, b in zip(numbers[:2], numbers[2:], strict=True)) < 0.005
    assert said.split()[-1] == "certain"


def test_a_program_drives_and_is_told_what_is_wrong():
    with serving("--robot", "kinematic", "--map", "stub", "--seed", "1") as server:
        code = example(ROOT / "docs" / "programs.md")
        assert "127.0.0.1:8080" in code
        lines = printed(code.replace("127.0.0.1:8080", server.address)).splitlines()
    assert lines[:2] == ["1 ack ", "2 error drive.v: Input should be a valid number"]
    assert lines[2].startswith("certain {'x': 0.")
