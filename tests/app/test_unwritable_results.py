"""Where results cannot be written, that is said before the work, with what would be valid."""

import os
import subprocess

import pytest

from app.command_line import main

SWEEP = "[settings]\nlocalization.filter.min_particles = [100, 200]\n"
FILES = {
    ("calibrate", "drive", "absent.mcap"): ("--out", "--report"),
    ("calibrate", "lens", "absent.png", "--squares", "9x6", "--size", "0.02"): (
        "--out",
        "--report",
    ),
    ("calibrate", "mounting", "absent.png"): ("--out", "--report"),
    ("map", "absent.mcap"): ("--out", "--report", "--calibrate"),
    ("map", "absent.log", "--method", "grid"): ("--out",),
}
"""Commands that write files, with nothing to read: who says so first has begun its work."""
ENDINGS = {"--out": ".toml", "--report": ".html", "--calibrate": ".toml"}
FOLDERS = (
    ("sweep", "sweep.toml"),
    ("evaluate", "--seeds", "1", "--world", "kinematic"),
    ("evaluate", "integrity", "--seeds", "1"),
    ("evaluate", "models", "--seeds", "2"),
    ("evaluate", "--recording", "absent.tum", "--truth", "absent.tum"),
)


@pytest.fixture
def sealed(tmp_path):
    """A folder that nobody may write to, nor root."""
    folder = tmp_path / "sealed"
    folder.mkdir()
    if os.getuid() != 0:
        folder.chmod(0o555)
        yield folder
        return
    mounted = ["mount", "-t", "tmpfs", "-o", "ro", "tmpfs", str(folder)]
    if subprocess.run(mounted, capture_output=True, check=False).returncode:
        pytest.skip("root may write everywhere, and may mount nothing here")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


def refused(capsys, *arguments):
    """What a command says that does nothing else."""
    assert main([str(each) for each in arguments]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    return told.err


@pytest.mark.parametrize(
    ("command", "option"),
    [(command, option) for command, options in FILES.items() for option in options],
)
def test_files(sealed, tmp_path, monkeypatch, capsys, command, option):
    monkeypatch.chdir(tmp_path)
    ending = ENDINGS[option]
    if command[0] == "map" and option == "--out":
        ending = ".yaml" if "grid" in command else ".svg"
    for out in (sealed / f"new{ending}", sealed / "below" / f"new{ending}"):
        told = refused(capsys, *command, option, out)
        assert told.startswith(f"brickpose: {out} cannot be written: ")
        assert "valid is a file in a folder that you may write to" in told
    taken = tmp_path / f"taken{ending}"
    taken.mkdir()
    assert f"{taken} cannot be written: Is a directory" in refused(capsys, *command, option, taken)


@pytest.mark.slow
@pytest.mark.parametrize("command", FOLDERS, ids=" ".join)
def test_folders(sealed, tmp_path, monkeypatch, capsys, command):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sweep.toml").write_text(SWEEP)
    for out in (sealed, sealed / "new"):
        told = refused(capsys, *command, "--out", out)
        assert told.startswith(f"brickpose: {out} cannot be written to: ")
        assert "valid is a folder that you may write to" in told


@pytest.mark.parametrize(
    ("method", "ending"),
    [
        *(("strokes", ending) for ending in (".svg", ".yaml", ".pgm", ".html")),
        *(("grid", ending) for ending in (".yaml", ".pgm", ".tum")),
    ],
)
def test_an_earlier_map_is_not_written_over(tmp_path, capsys, method, ending):
    drawing = method == "strokes"
    precious = tmp_path / f"floor{ending}"
    precious.write_text("precious")
    out = tmp_path / f"floor{'.svg' if drawing else '.yaml'}"
    source = "absent.mcap" if drawing else "absent.log"
    told = refused(capsys, "map", source, "--method", method, "--out", out)
    assert (
        told == f"brickpose: {precious} would be overwritten; valid is another name, or --force\n"
    )
    assert precious.read_text() == "precious"
    assert main(["map", source, "--method", method, "--out", str(out), "--force"]) != 0
    assert "overwritten" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("command", "out", "taken"),
    [
        (("lens", "absent.png"), "camera.yaml", "camera.yaml"),
        (("lens", "absent.png"), "camera.yaml", "camera.html"),
        (("lens", "absent.png"), "robot.toml", "robot.html"),
        (("mounting", "absent.png"), "robot.toml", "robot.png"),
        (("drive", "absent.mcap"), "robot.toml", "robot.html"),
        (("drive", "absent", "--odometry", "absent.tum"), "camera.yaml", "camera.yaml"),
        (("drive", "absent", "--odometry", "absent.tum"), "camera.yaml", "camera.html"),
    ],
)
def test_no_calibration_is_written_over_a_file_of_somebody_else(
    tmp_path, monkeypatch, capsys, command, out, taken
):
    monkeypatch.chdir(tmp_path)
    precious = tmp_path / taken
    precious.write_text("precious")
    told = refused(capsys, "calibrate", *command, "--out", out)
    assert told == f"brickpose: {taken} would be overwritten; valid is another name, or --force\n"
    assert precious.read_text() == "precious"
    assert main(["calibrate", *command, "--out", out, "--force"]) != 0
    assert "overwritten" not in capsys.readouterr().err
    if out.endswith(".toml"):
        # The report of a profile that is measured again is written anew.
        (tmp_path / out).write_text("")
        assert main(["calibrate", *command, "--out", out]) != 0
        assert "overwritten" not in capsys.readouterr().err
