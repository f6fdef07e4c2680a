"""``brickpose localize`` with a folder of pictures on a field of light, dashed, curved tape."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from exif_pictures import tiff_header, with_exif
from scipy.spatial.transform import Rotation
from taped_road import RoadDrive, drive, name

from app.command_line import main
from app.features.lab.trajectories.reading import parse_tum
from app.trajectories.trajectory import Trajectory
from app.trajectories.tum_file import write_tum
from robot.description.camera_file import BODY_FROM_OPTICAL, with_camera
from robot.description.spec import RobotSpec
from robot.geometry import Pose2
from robot.lens_files.reading import read_lens_file


@pytest.fixture(scope="module")
def road_drive(tmp_path_factory: pytest.TempPathFactory) -> RoadDrive:
    return drive(tmp_path_factory.mktemp("road"))


def located(seen: RoadDrive, out: Path, *options: object) -> Trajectory:
    arguments = [seen.folder, "--map", seen.field, "--out", out, *options]
    assert main(["localize", *map(str, arguments)]) == 0
    return parse_tum(out.read_text(), out.name)


def errors(seen: RoadDrive, trajectory: Trajectory) -> np.ndarray:
    """Distance [m] of each pose from the truth."""
    places = {round(stamp, 6): pose for stamp, pose in zip(seen.stamps, seen.truth, strict=True)}
    true = np.array([places[round(float(stamp), 6)].to_array() for stamp in trajectory.stamps])
    return np.hypot(*(trajectory.poses - true)[:, :2].T)


def refused(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str]:
    code = main(["localize", *map(str, arguments)])
    lines = capsys.readouterr().err.strip().splitlines()
    assert len(lines) == 1, lines
    return code, lines[0]


@pytest.mark.slow
def test_a_robot_is_followed_by_pictures_and_odometry(road_drive, tmp_path, capsys) -> None:
    shown = tmp_path / "shown"
    options = ("--odometry", road_drive.odometry, "--overlays", shown)
    trajectory = located(road_drive, tmp_path / "out.tum", *options)
    assert len(trajectory.stamps) == len(road_drive.stamps)
    assert errors(road_drive, trajectory)[3:].max() < 0.012
    assert (
        f"{len(road_drive.stamps)} of {len(road_drive.stamps)} pictures" in capsys.readouterr().out
    )
    overlay = cv2.imread(str(shown / Path(name(road_drive.stamps[0])).with_suffix(".png")))
    assert (overlay == (0, 255, 0)).all(axis=2).sum() > 100


@pytest.mark.slow
@pytest.mark.parametrize("orientation", [3, 6])
def test_pictures_that_ask_to_be_turned_are_followed_as_they_are(
    orientation: int, road_drive, tmp_path, capsys
) -> None:
    folder = tmp_path / "pictures"
    folder.mkdir()
    for path in road_drive.folder.iterdir():
        png = cv2.imencode(".png", cv2.imread(str(path)))[1].tobytes()
        turned = with_exif(png, tiff_header(orientation))
        (folder / path.with_suffix(".png").name).write_bytes(turned)
    odometry = "--odometry", road_drive.odometry
    plain = located(road_drive, tmp_path / "plain.tum", *odometry)
    assert "EXIF" not in capsys.readouterr().out
    trajectory = located(replace(road_drive, folder=folder), tmp_path / "out.tum", *odometry)
    np.testing.assert_array_equal(trajectory.poses, plain.poses)
    count = len(road_drive.stamps) - 1
    assert f"(and {count} others) says by EXIF that it is to be" in capsys.readouterr().out


@pytest.mark.parametrize("kind", ["particles", "kalman", "hypotheses"])
def test_a_wrong_start_is_lost_with_every_filter_and_never_certain(
    kind: str, road_drive, tmp_path, capsys
) -> None:
    config = tmp_path / "filter.toml"
    config.write_text(f'[localization.filter]\nfilter = "{kind}"\n')
    options = ["--odometry", road_drive.odometry, "--config", config]
    located(road_drive, tmp_path / "right.tum", *options)
    told = capsys.readouterr().out
    assert int(told.split("lie on the field: ")[1].split("%")[0]) > 90
    assert "lost in" not in told
    wrong = "--initial-pose", -0.5, 0.2, 0.8, "--sd-xy", 0.02, "--sd-theta", 0.05
    located(road_drive, tmp_path / "wrong.tum", *options, *wrong)
    told = capsys.readouterr().out
    assert " certain" not in told
    assert "lost in" in told
    assert float(told.split("first ")[1].split()[0]) <= 2.0


def test_nothing_is_written_over_files_of_somebody_else(road_drive, tmp_path, capsys) -> None:
    shown = tmp_path / "shown"
    shown.mkdir()
    out, overlay = tmp_path / "way.tum", shown / f"{Path(name(road_drive.stamps[3])).stem}.png"
    command = road_drive.folder, "--map", road_drive.field, "--out", out, "--overlays", shown
    for precious in (out, overlay):
        precious.write_text("precious")
        code, told = refused(capsys, *command)
        assert code == 2 and f"{precious} would be overwritten; valid is another name" in told
        assert precious.read_text() == "precious"
        precious.unlink()
    assert main(["localize", *map(str, command)]) == 0
    assert refused(capsys, *command)[0] == 2
    assert main(["localize", *map(str, command), "--force"]) == 0


def test_pictures_that_are_read_are_never_drawn_on(road_drive, tmp_path, capsys) -> None:
    folder = tmp_path / "pictures"
    folder.mkdir()
    for path in road_drive.folder.iterdir():
        shutil.copy(path, (folder / path.name).with_suffix(".png"))
    before = {path: path.read_bytes() for path in folder.iterdir()}
    options = "--map", road_drive.field, "--overlays", folder, "--force"
    code, told = refused(capsys, folder, *options, "--out", tmp_path / "way.tum")
    assert code == 2 and f"--overlays is {folder}, whose pictures are read" in told
    assert {path: path.read_bytes() for path in folder.iterdir()} == before


def test_without_odometry_no_bound_is_told(road_drive, tmp_path, capsys) -> None:
    located(road_drive, tmp_path / "out.tum")
    told = capsys.readouterr().out
    assert " certain" not in told
    assert "in no picture a bound can be told" in told
    assert "without --odometry" in told


def test_without_odometry_it_goes_on_as_it_went(road_drive, tmp_path) -> None:
    trajectory = located(road_drive, tmp_path / "out.tum")
    true = np.array([pose.to_array() for pose in road_drive.truth])
    off = np.abs(trajectory.poses - true)[3:]
    assert off[:-6, :2].max() < 0.012
    # At the end all tape in sight runs along y: of that nothing tells, and a motion that goes on as
    # it went drifts.
    assert off[-6:, 0].max() < 0.004
    assert off[-6:, 1].max() < 0.05


def test_a_stale_picture_is_told_by_name_and_left_out(road_drive, tmp_path, capsys) -> None:
    folder = tmp_path / "pictures"
    shutil.copytree(road_drive.folder, folder)
    names = [name(stamp) for stamp in road_drive.stamps]
    # The camera stalled: it shows for a second what it saw before.
    for late in range(8, 14):
        (folder / names[late]).unlink()
    shutil.copy(folder / names[7], folder / names[13])
    seen = replace(road_drive, folder=folder)
    trajectory = located(seen, tmp_path / "out.tum", "--odometry", seen.odometry)
    assert f"{names[13]} is stale" in capsys.readouterr().out
    assert len(trajectory.stamps) == len(names) - 6
    assert errors(seen, trajectory)[3:].max() < 0.012


def test_an_odometry_that_jumps_is_told_and_costs_one_picture(road_drive, tmp_path, capsys) -> None:
    moved = parse_tum(road_drive.odometry.read_text(), "odometry")
    jump = Pose2(0.0, 0.0, 0.45)
    after = [(jump @ Pose2.from_array(pose)).to_array() for pose in moved.poses[12:]]
    write_tum(
        tmp_path / "jump.tum",
        Trajectory.of_poses(list(moved.stamps), np.vstack([moved.poses[:12], after])),
    )
    trajectory = located(road_drive, tmp_path / "out.tum", "--odometry", tmp_path / "jump.tum")
    told = capsys.readouterr().out
    assert "is stale" not in told, told
    assert f"{name(road_drive.stamps[12])} is left out: picture and odometry disagree" in told
    assert "odometry jumped" in told
    assert len(trajectory.stamps) == len(road_drive.stamps) - 1


def test_half_a_picture_and_what_macos_leaves_beside_pictures_cost_only_themselves(
    road_drive, tmp_path, capsys
) -> None:
    folder = tmp_path / "pictures"
    shutil.copytree(road_drive.folder, folder)
    names = [name(stamp) for stamp in road_drive.stamps]
    for each in names:
        (folder / f"._{each}").write_bytes(b"\0\5\x16\7\0\2\0\0Mac OS X        " + bytes(99))
    for cut in (0, 11, len(names) - 1):  # switched off while it wrote
        content = (folder / names[cut]).read_bytes()
        (folder / names[cut]).write_bytes(content[: len(content) // 2])
    seen = replace(road_drive, folder=folder)
    trajectory = located(seen, tmp_path / "out.tum", "--odometry", seen.odometry)
    told = capsys.readouterr().out
    for cut in (0, 11, len(names) - 1):
        assert f"{names[cut]} is left out: it is no picture that can be read" in told
    assert f"{len(names) - 3} of {len(names)} pictures" in told
    assert len(trajectory.stamps) == len(names) - 3
    assert errors(seen, trajectory)[3:].max() < 0.012


def test_stamps_may_come_from_a_list(road_drive, tmp_path) -> None:
    listed = tmp_path / "frames.csv"
    rows = [f"{name(stamp)},{stamp:.6f},x" for stamp in road_drive.stamps]
    listed.write_text("image,t,note\n" + "\n".join(rows))
    by_list = located(road_drive, tmp_path / "a.tum", "--stamps", listed)
    by_name = located(road_drive, tmp_path / "b.tum")
    np.testing.assert_allclose(by_list.poses, by_name.poses, atol=1e-6)


def test_pictures_beyond_the_odometry_are_told(road_drive, tmp_path, capsys) -> None:
    lines = road_drive.odometry.read_text().splitlines()
    short = tmp_path / "short.tum"
    short.write_text("\n".join(lines[:-4]))
    trajectory = located(road_drive, tmp_path / "out.tum", "--odometry", short)
    assert len(trajectory.stamps) == len(road_drive.stamps) - 4
    told = capsys.readouterr().out
    assert f"{name(road_drive.stamps[-1])} is left out: odometry tells nothing" in told


def test_bad_folders_are_refused_in_one_line(road_drive, tmp_path, capsys) -> None:
    empty = tmp_path / "empty"
    empty.mkdir()
    out = tmp_path / "never.tum"
    rest = ("--map", road_drive.field, "--out", out)
    code, line = refused(capsys, empty, *rest)
    assert code == 1 and "has no pictures; valid are files that end in .bmp" in line
    (empty / "frame_0001.png").write_bytes(b"no picture")
    code, line = refused(capsys, empty, *rest)
    assert code == 1 and "frame_0001.png tells no stamp; valid are names that end in" in line
    (empty / "frame_0001.png").rename(empty / "1.5.png")
    code, line = refused(capsys, empty, *rest)
    assert code == 1 and "1.5.png is no picture that can be read; replace or remove it" in line
    cv2.imwrite(str(empty / "1.5.png"), np.zeros((48, 64), np.uint8))
    code, line = refused(capsys, empty, *rest)
    assert code == 1 and "64 x 48 px, but the lens is described for 640 x 480 px" in line
    (empty / "1.50.png").write_bytes(b"no picture")
    code, line = refused(capsys, empty, *rest)
    assert code == 1 and "have the same stamp 1.500000 s" in line
    assert not out.exists()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "lists no picture"),
        ("1.0", "list.txt:1: a stamp and the name of a picture are due"),
        ("soon a.jpg", "'soon' is no stamp"),
        ("nan a.jpg", "'nan' is no stamp"),
        ("1.0 none.jpg", "there is no picture 'none.jpg'"),
    ],
)
def test_bad_lists_are_refused(content, message, road_drive, tmp_path, capsys) -> None:
    listed = tmp_path / "list.txt"
    listed.write_text(content)
    code, line = refused(capsys, road_drive.folder, "--map", road_drive.field, "--stamps", listed)
    assert code == 1 and message in line


def test_options_of_the_other_kind_are_refused(road_drive, tmp_path, capsys) -> None:
    given = (road_drive.folder, "--map", road_drive.field)
    code, line = refused(capsys, *given, "--scan-topic", "/scan")
    assert code == 2 and "--scan-topic has no effect with a folder of pictures" in line
    code, line = refused(capsys, tmp_path / "x.bag", "--map", "m.yaml", "--overlays", tmp_path)
    assert code == 2 and "--overlays has no effect with a bag" in line
    code, line = refused(capsys, *given, "--profile", tmp_path / "none.toml")
    assert code == 1 and "none.toml cannot be read" in line
    code, line = refused(capsys, *given, "--initial-pose", 9, 9, 0)
    assert code == 2 and "is not on the field road" in line


CAMERA = """image_width: 640
image_height: 480
camera_matrix: {rows: 3, cols: 3, data: [500, 0, 320, 0, 500, 240, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}
"""


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ("mounting: {xyz: [0, 0, 0.1]}", "mounting needs xyz: [x, y, z] in m and rpy"),
        ("mounting: {xyz: [0, 0], rpy: [0, 0.3, 0]}", "mounting.xyz needs a list of three"),
        ("mounting: {xyz: [0, 0, .inf], rpy: [0, 0.3, 0]}", "mounting.xyz has '.inf'"),
        ("mounting: {xyz: [0, 0, -0.1], rpy: [0, 0.3, 0]}", "the camera is -0.1 m high"),
        ("mounting: {xyz: [0, 0, 0.1], rpy: [0, -0.3, 0]}", "the camera looks up or level"),
        ("picture_delay: 3", "picture_delay has '3'; valid is -1 to 1 s"),
    ],
)
def test_bad_cameras_are_refused(more, message, road_drive, tmp_path, capsys) -> None:
    path = tmp_path / "camera.yaml"
    path.write_text(CAMERA + more)
    code, line = refused(capsys, road_drive.folder, "--map", road_drive.field, "--camera", path)
    assert code == 1 and message in line


def test_a_mounting_like_the_robots_own_is_the_robots_own(tmp_path) -> None:
    spec = RobotSpec.load()
    pose = spec.robot_from_camera
    rpy = Rotation.from_matrix(pose[:3, :3] @ BODY_FROM_OPTICAL.T).as_euler("xyz")
    path = tmp_path / "camera.yaml"
    path.write_text(
        CAMERA + f"mounting: {{xyz: {pose[:3, 3].tolist()}, rpy: {rpy.tolist()}}}\n"
        "picture_delay: 0.05\n"
    )
    built = with_camera(spec, read_lens_file(path))
    np.testing.assert_allclose(built.robot_from_camera, pose, atol=1e-9)
    assert built.picture_delay == 0.05 and built.lens.matrix[0, 0] == 500
