"""The wheel works alone: built from the sources' archive, in a path with a space and an umlaut."""

import json
import os
import re
import subprocess
import sys
import sysconfig
import tarfile
import venv
from urllib.request import urlopen
from zipfile import ZipFile

import pytest

from app.features.course.lesson import lessons
from app.settings.config import MAPS, ROOT

pytestmark = pytest.mark.slow

LIMIT_S = 120
ANSWER_S = 30


def build(sources, kind, into):
    """What hatchling makes of a folder; the one file of its kind."""
    command = [sys.executable, "-m", "hatchling", "build", "-t", kind, "-d", str(into)]
    subprocess.run(command, cwd=sources, check=True, capture_output=True, timeout=LIMIT_S)
    (made,) = into.glob("*.whl" if kind == "wheel" else "*.tar.gz")
    return made


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("Mein Ordner für Räder")


@pytest.fixture(scope="module")
def wheel(folder):
    """Made of the archive, as installers do that have only this."""
    with tarfile.open(build(ROOT, "sdist", folder)) as archive:
        archive.extractall(folder, filter="data")
    (sources,) = folder.glob("brickpose-*/")
    return build(sources, "wheel", folder)


@pytest.fixture(scope="module")
def environment(folder, wheel):
    """A new one, which has the wheel, and sees the packages that are installed for these tests."""
    place = folder / "env"
    venv.EnvBuilder(symlinks=os.name != "nt").create(place)
    python = place / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    subprocess.run(
        [sys.executable, "-m", "pip", "--python", str(python), "install", "--quiet", "--no-deps",
         "--no-index", str(wheel)],
        check=True, timeout=LIMIT_S,
    )  # fmt: skip
    # Only the folder: what its own *.pth files name, as our checkout, is not seen.
    (packages,) = place.glob("**/site-packages")
    (packages / "tests.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    return python.parent


def run_in(environment, folder, *command, **options):
    return subprocess.Popen(
        [str(environment / command[0]), *command[1:]],
        cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True,
        encoding="utf-8", env={k: v for k, v in os.environ.items() if k != "PYTHONPATH"}, **options,
    )  # fmt: skip


@pytest.fixture(scope="module")
def address(environment, folder):
    """Of the program with the course, started by its command."""
    # Compiling first is what test_first_start.py is about: here the server is enough.
    mark = "from app.engine.compiling.compilation import Compilation; Compilation().mark()"
    with run_in(environment, folder, "python", "-c", mark) as marking:
        marking.communicate(timeout=LIMIT_S)
    words = ("learn", "1", "--file", "meine Lösung.py", "--port", "0", "--robot", "kinematic")
    with run_in(environment, folder, "brickpose", *words) as process:
        try:
            said = ""
            while (found := re.search(r"http://[\d.]+:\d+", said)) is None:
                line = process.stdout.readline()
                assert line, f"it did not start: {said}"
                said += line
            yield found[0]
        finally:
            process.terminate()
            process.communicate(timeout=LIMIT_S)


def get(address, path):
    with urlopen(address + path, timeout=ANSWER_S) as answer:
        return answer.read().decode()


def test_the_wheel_of_the_archive_is_the_wheel_of_the_checkout(wheel, tmp_path):
    with ZipFile(wheel) as one, ZipFile(build(ROOT, "wheel", tmp_path)) as other:
        assert sorted(one.namelist()) == sorted(other.namelist())


def test_only_packages_are_installed(wheel):
    with ZipFile(wheel) as archive:
        tops = {name.partition("/")[0] for name in archive.namelist()}
        assert "brickpose/py.typed" in archive.namelist()
    assert {top for top in tops if "." not in top} == {"app", "brickpose", "robot", "sim"}


def test_no_file_of_the_checkout_is_used(environment, folder):
    script = "import app, brickpose, robot, sim\n"
    script += "for module in (app, brickpose, robot, sim): print(module.__file__)"
    with run_in(environment, folder, "python", "-c", script) as process:
        files = process.communicate(timeout=LIMIT_S)[0].split("\n")[:-1]
    assert len(files) == 4
    assert all(str(environment.parent) in file for file in files)


def test_the_page_and_its_parts_are_in_the_wheel(address):
    page = get(address, "/")
    parts = re.findall(r'(?:src|href)="(/?[\w/.-]+\.(?:js|css))"', page)
    assert len(parts) > 1
    for part in parts:
        assert get(address, "/" + part.removeprefix("/"))


def test_maps_documents_and_lessons_are_in_the_wheel(address, folder):
    fields = re.findall(r"[\w-]+", get(address, "/api/fields"))
    assert {path.stem for path in MAPS.glob("*.svg")} <= set(fields)
    assert "BrickPose" in get(address, "/help/design.md")
    assert len(json.loads(get(address, "/api/lessons"))) == len(lessons(None))
    assert (folder / "meine Lösung.py").read_text(encoding="utf-8").startswith('"""')
