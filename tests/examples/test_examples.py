"""The examples of ``examples/``, README and the page for programs do what is said of them."""

import json
import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest
from engine_runs import drive, kinematic
from engine_runs import run as drive_for
from recordings import record
from serving import ROOT, ask, serving

from app.engine.build import build_program
from app.engine.plugging import plug_in, plugged
from app.feature import Feature
from app.settings.config import Config
from robot.localization.estimate import State

pytestmark = pytest.mark.slow

EXAMPLES = ROOT / "examples"
LONGEST = 40
"""No example has more lines."""


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


@pytest.fixture
def run(monkeypatch, capsys):
    """Runs an example with arguments, as a main program; returns what it prints."""

    def run_example(name: str, *arguments: str) -> list[str]:
        monkeypatch.setattr(sys, "argv", [name, *arguments])
        runpy.run_path(str(EXAMPLES / name), run_name="__main__")
        return capsys.readouterr().out.splitlines()

    return run_example


def poses(line: str) -> tuple[float, float]:
    """How far two poses in a line lie apart in x and in y [m]."""
    numbers = [float(number) for number in re.findall(r"(?:x|y)=(-?[\d.]+(?:e-?\d+)?)", line)]
    return abs(numbers[0] - numbers[2]), abs(numbers[1] - numbers[3])


@pytest.mark.parametrize("script", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.stem)
def test_an_example_is_short(script):
    assert len(script.read_text(encoding="utf-8").splitlines()) <= LONGEST


@pytest.mark.parametrize("name", ["figure_eight", "own_robot", "own_sensor_model"])
def test_the_filter_knows_where_the_robot_is(run, name):
    (said,) = run(f"{name}.py")
    assert max(poses(said)) < 0.005
    assert "certain" in said


def test_an_own_planner_and_an_own_controller_bring_the_robot_to_its_goal(run):
    (said,) = run("own_controller.py")
    assert said.startswith("arrived; ;")
    x, y = (float(re.search(rf"{axis}=(-?[\d.]+)", said)[1]) for axis in "xy")
    assert abs(x - 0.25) < 0.002
    assert abs(y - 0.2) < 0.002


@pytest.mark.parametrize("name", ["drive_square", "localize_scan", "own_filter"])
def test_at_the_end_of_a_drive_it_is_millimetres_off(run, name):
    said = run(f"{name}.py")
    assert len(said) >= 3
    assert float(re.search(r"([\d.]+) mm off", said[-1])[1]) < 5.0


def test_more_particles_are_more_exact(run):
    few, many = (float(re.search(r"([\d.]+) mm", line)[1]) for line in run("compare_settings.py"))
    assert many < few < 50.0


def test_a_package_s_robot_with_a_camera_is_followed_on_wheels_of_its_own():
    before = plugged().features
    robots = runpy.run_path(str(EXAMPLES / "feature_package" / "tape_seen" / "rover.py"))["robots"]
    plug_in(before.adding(Feature(name="rover", about="", robots=(robots,))))
    try:
        program = build_program(Config(robot="rover", map="square"))
        shown = drive_for(program, 5.0, drive(0.1, 0.8))
        program.robot.close()
    finally:
        plug_in(before)
    assert program.robot.spec.wheel_radius == pytest.approx(0.035)
    assert shown[-1].integrity.state is State.CERTAIN
    assert shown[-1].truth.distance_to(shown[-1].pose) < 0.005
    assert shown[-1].truth.distance_to(shown[0].truth) > 0.1


def test_a_picture_is_scanned(run):
    hits, nearest = run("scan_picture.py")
    assert int(hits.split()[0]) > 10
    assert 50.0 < float(re.search(r"([\d.]+) mm", nearest)[1]) < 600.0


def test_a_drive_is_plotted(run, tmp_path):
    run("plot_drive.py", str(tmp_path / "drive.svg"))
    drawn = (tmp_path / "drive.svg").read_text(encoding="utf-8")
    assert drawn.count("line2d_") > 10


def test_a_recording_is_read(run, tmp_path):
    folder, _, _ = record(kinematic(), tmp_path, 2.0)
    (said,) = run("read_recording.py", str(folder))
    assert int(said.split()[0]) > 30


def test_the_cells_of_the_notebook_run():
    notebook = json.loads((EXAMPLES / "drive.ipynb").read_text(encoding="utf-8"))
    cells = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
    code = "\n".join(cells).replace(
        "%matplotlib inline", "import matplotlib; matplotlib.use('svg')"
    )
    assert printed(code).split()[-1] == "certain"


def test_the_notebook_with_the_page_steps_it():
    notebook = json.loads((EXAMPLES / "page.ipynb").read_text(encoding="utf-8"))
    cells = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
    code = cells[0] + "._repr_html_()\n" + "\n".join(cells[1:])
    said = printed(code).splitlines()
    assert said[0].startswith("certain")
    assert said[1] in ("lost", "ambiguous", "approximate")


def test_the_loop_without_a_server_knows_where_the_robot_is():
    said = printed(example(ROOT / "README.md"))
    assert max(poses(said)) < 0.005
    assert said.split()[-1] == "certain"


@pytest.fixture(scope="module")
def server():
    with serving("--robot", "kinematic", "--map", "stub", "--seed", "1") as running:
        yield running


def test_a_program_drives_and_is_told_what_is_wrong(server):
    code = example(ROOT / "docs" / "programs.md")
    assert "127.0.0.1:8080" in code
    lines = printed(code.replace("127.0.0.1:8080", server.address)).splitlines()
    assert lines[:2] == ["1 ack ", "2 error drive.v: Input should be a valid number"]
    assert lines[2].startswith("certain {'x': 0.")


def test_a_client_drives(run, server):
    (said,) = run("live_client.py", f"ws://{server.address}/api/live")
    assert said.startswith("certain {'x': ")


def test_a_client_sends_the_robot_to_a_place(run, server):
    with server.live() as live:
        for command in ("place", "set_pose"):  # others may have left it where it cannot turn
            ask(live, type=command, x=-0.1, y=-0.2, theta=0.0)
    said = run("go_to.py", "-0.1", "0.05", "90", f"ws://{server.address}/api/live")
    assert said[-1].startswith("arrived")


def test_a_client_of_rosbridge_drives(run, server):
    (said,) = run("rosbridge_client.py", f"ws://{server.address}/rosbridge")
    assert said.startswith("/amcl_pose {'x': ")
