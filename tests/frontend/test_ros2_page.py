"""The programs in docs/ros2.md run as they stand there."""

import re
import subprocess
import sys

import pytest
from node_peers import MODULES, needs_node
from serving import ROOT, ask, until

pytestmark = pytest.mark.slow

PAGE = (ROOT / "docs" / "ros2.md").read_text(encoding="utf-8")


def program(language: str, server) -> str:
    (text,) = re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)
    assert "127.0.0.1:8080" in text
    return text.replace("127.0.0.1:8080", server.address)


def run_beside(live, command, text, **options):
    """Run it; the robot moves meanwhile, and stands afterwards."""
    process = subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, **options
    )
    try:
        process.stdin.write(text)
        process.stdin.close()
        until(live, lambda now: now["twist"]["v"] > 0.05, 60)
        until(live, lambda now: now["twist"]["v"] == 0, 60)
        said = process.stdout.read()
        assert process.wait(60) == 0
    finally:
        process.kill()
        process.wait()
        process.stdout.close()
    return said


@needs_node
def test_the_page_for_roslibjs(server, live):
    text = program("js", server)
    said = run_beside(live, ["node", "--input-type=module", "-"], text, cwd=MODULES)
    assert re.search(r"nearest tape: [\d.]+ m", said)
    assert "the robot may be anywhere" in said


def test_the_program_for_roslibpy(server, live):
    pytest.importorskip("roslibpy")
    ask(live, type="reset")  # the page before it has scattered the cloud
    said = run_beside(live, [sys.executable, "-"], program("python", server))
    assert "'x': " in said
