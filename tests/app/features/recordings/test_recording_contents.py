"""What a recording has beside its messages is enough to build the same robot on the same field."""

import json
from dataclasses import dataclass, field, replace
from pathlib import Path

import pytest
from engine_runs import kinematic
from recordings import record
from simulators import ENGINES, require_engine

from app.engine.build import build_program
from app.features.recordings.attachments import SETTINGS, URDF, VERSIONS, as_toml
from app.features.recordings.contents import contents_of
from app.features.recordings.files.mcap_reader import open_recording
from app.features.recordings.replay.opening import ReplayOptions, open_replay
from app.messages.commands import SetParametersCommand
from app.settings.config import MAPS, Config, load_config
from robot.description.spec import RobotSpec
from robot.fields.field_loading import load_field
from robot.fields.grid_map import save_map_yaml
from sim.floor_camera import CameraSettings
from sim.simulated import SimSettings


def unpacked(program, folder):
    contents = contents_of(program)
    for one in contents.attachments:
        path = folder / one.name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(one.data)
    return contents


@dataclass(frozen=True)
class Lamps:
    """Settings of somebody's feature."""

    bright: list[float] = field(default_factory=list)
    colours: dict[str, str] = field(default_factory=dict)
    rows: list[dict[str, int]] = field(default_factory=list)


@pytest.mark.parametrize("engine", ENGINES)
def test_it_says_which_physics_engine_drove(engine):
    require_engine(engine)
    program = build_program(Config(robot="sim", sim=SimSettings(engine=engine)))
    facts = contents_of(program).facts
    program.robot.close()
    assert facts["engine"].startswith(f"{engine} ")
    assert contents_of(kinematic()).facts["engine"] == ""


def test_the_settings_can_be_loaded_again(tmp_path):
    config = Config(
        robot="kinematic",
        seed=42,
        host='a "host"\\\x7f\n',
        sim=SimSettings(camera=CameraSettings(frame_rate=15)),
        start_pose=replace(
            Config().start_pose,
            initial_pose=replace(
                Config().start_pose.initial_pose, covariance=(1e-3, 0, 0, 0, 1e-3, 0, 0, 0, 0.1)
            ),
        ),
        added={
            "lamps": {"bright": [0.5, 1], "colours": {'at the "left"': "red"}, "rows": [{"n": 1}]}
        },
    )
    path = tmp_path / "settings.toml"
    path.write_text(as_toml(config), encoding="utf-8")
    assert "[lamps]" in path.read_text(encoding="utf-8")  # as in a file of settings
    assert load_config(path, {"lamps": Lamps()}) == config
    path.write_text(as_toml(Config()), encoding="utf-8")
    assert load_config(path) == Config()


def test_the_settings_are_those_of_the_moment(tmp_path):
    program = kinematic(seed=9)
    values = {"max_particles": 777}
    program.engine.commands.put(SetParametersCommand(type="set_parameters", values=values))
    program.engine.step()
    unpacked(program, tmp_path)
    config = load_config(tmp_path / SETTINGS)
    assert config.localization.filter.max_particles == 777
    assert replace(config, localization=program.config.localization) == program.config


def test_the_field_and_the_robot_can_be_built_of_it(tmp_path):
    program = kinematic(map="stub")
    contents = unpacked(program, tmp_path)
    assert contents.facts["map"] == "stub"
    field = load_field(str(tmp_path / contents.facts["map_file"]), MAPS)
    assert field.edges.tolist() == program.field.edges.tolist()
    spec = RobotSpec.load(tmp_path / URDF)
    assert spec.lens.matrix.tolist() == program.robot.spec.lens.matrix.tolist()
    assert spec.track == program.robot.spec.track
    assert spec.robot_from_camera.tolist() == program.robot.spec.robot_from_camera.tolist()


def test_a_ros_map_comes_with_its_picture_wherever_that_lies(tmp_path):
    grid = load_field("square", MAPS).occupancy(0.01)
    away = tmp_path / "away"
    away.mkdir()
    save_map_yaml(grid, away / "lab.yaml")
    yaml = (away / "lab.yaml").read_text(encoding="utf-8")
    (tmp_path / "here").mkdir()
    moved = tmp_path / "here" / "lab.yaml"
    moved.write_text(yaml.replace("image: lab", f"image: {away}/lab"), encoding="utf-8")
    program = kinematic(map=str(moved))
    contents = unpacked(program, tmp_path / "out")
    field = load_field(str(tmp_path / "out" / contents.facts["map_file"]), MAPS)
    assert field.grid.data.tolist() == program.field.grid.data.tolist()
    assert field.grid.resolution == program.field.grid.resolution
    assert str(away) not in (tmp_path / "out" / contents.facts["map_file"]).read_text()


def test_a_model_of_ones_own_is_in_it(tmp_path, save):
    path = save(
        """
        import numpy as np
        class Same:
            def log_likelihood(self, poses, scan):
                return np.zeros(len(poses))
        """
    )
    program = build_program(Config(robot="kinematic", sensor_model=f"{path}:Same"))
    unpacked(program, tmp_path / "out")
    assert (tmp_path / "out" / "models" / "mine.py").read_bytes() == path.read_bytes()


def test_versions_and_facts_tell_what_made_it(tmp_path):
    program = kinematic(seed=4)
    contents = unpacked(program, tmp_path)
    known = json.loads((tmp_path / VERSIONS).read_text())
    assert known["brickpose"] == contents.facts["version"]
    assert contents.facts["seed"] == "4"
    assert contents.facts["robot"] == "Kinematic robot"
    assert all(isinstance(one, str) for one in contents.facts.values())


def test_names_stay_within_their_folder():
    for one in contents_of(kinematic()).attachments:
        assert not Path(one.name).is_absolute()
        assert ".." not in Path(one.name).parts
        assert one.media_type != "application/octet-stream"


def test_a_map_that_is_gone_is_told(tmp_path):
    drawing = tmp_path / "mine.svg"
    drawing.write_bytes((MAPS / "square.svg").read_bytes())
    program = kinematic(map=str(drawing))
    drawing.unlink()
    with pytest.raises(OSError, match=r"mine\.svg"):
        contents_of(program)


def test_a_recorded_replay_has_the_map_and_the_robot_of_the_first_recording(tmp_path):
    made, _, _ = record(kinematic(map="tee"), tmp_path / "made", 0.2)
    first = dict(open_recording(made).attachments)
    contents = contents_of(open_replay(made, ReplayOptions()))
    again = {one.name: one.data for one in contents.attachments}
    assert (contents.facts["map"], contents.facts["map_file"]) == ("tee", "map/tee.svg")
    parts = {name for name in first if name.startswith(("map/", "robot/"))}
    assert parts == {name for name in again if name.startswith(("map/", "robot/"))}
    assert {name: again[name] for name in parts} == {name: first[name] for name in parts}
    other = contents_of(open_replay(made, ReplayOptions(map="stub")))
    assert other.facts["map_file"] == "map/stub.svg"
