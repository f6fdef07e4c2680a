"""``brickpose replay``: what it writes, and what it refuses in words."""

import re
import tomllib

import numpy as np
import pytest
from mcap.reader import make_reader
from replays import recorded_eight

from app.command_line import main
from app.features.lab.trajectories.reading import parse_tum
from app.features.recordings.replay.opening import ReplayOptions, with_filter_config
from app.features.recordings.replay_command import replay
from app.settings.config import Config
from robot.settings import SettingError


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return recorded_eight(tmp_path_factory.mktemp("recordings"), seconds=4)


def written(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.slow
def test_it_writes_what_was_estimated_now_and_then_and_the_truth(recording, tmp_path, capsys):
    made, shown = recording
    assert main(["replay", str(made), "--out", str(tmp_path / "a")]) == 0
    files = written(tmp_path / "a")
    assert set(files) == {"estimated.tum", "then.tum", "truth.tum", "odometry.tum"}
    assert "estimated.tum" in capsys.readouterr().out
    for name, data in files.items():
        assert parse_tum(data.decode(), name).stamps[-1] == pytest.approx(3.98, abs=0.03)
    truth = parse_tum(files["truth.tum"].decode(), "truth").poses
    assert truth[-1] == pytest.approx(shown[-1].truth.to_array(), abs=1e-4)
    assert main(["replay", str(made), "--out", str(tmp_path / "b")]) == 0
    assert written(tmp_path / "b") == files


def test_damage_in_the_middle_is_told_and_all_else_is_written(recording, tmp_path, capsys):
    made, _ = recording
    (file,) = made.glob("*.mcap")
    data = bytearray(file.read_bytes())
    with file.open("rb") as stream:
        chunks = make_reader(stream).get_summary().chunk_indexes
    hurt = chunks[len(chunks) // 2]
    middle = hurt.chunk_start_offset + hurt.chunk_length // 2
    data[middle : middle + 100] = bytes(100)
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(data)
    assert main(["replay", str(damaged), "--out", str(tmp_path / "out")]) == 0
    assert re.search(r"In the recording, 0\.\d s from \d", capsys.readouterr().out)
    last = parse_tum((tmp_path / "out" / "truth.tum").read_text(), "truth").stamps[-1]
    assert last > 3.5


def test_damaged_settings_are_told_and_replaced_by_the_program_s_own(recording, tmp_path, capsys):
    made, _ = recording
    (file,) = made.glob("*.mcap")
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(
        file.read_bytes().replace(b"[localization.filter]", b"[localizatio#.filter]")
    )
    assert main(["replay", str(damaged), "--out", str(tmp_path / "out")]) == 0
    told = capsys.readouterr().out
    assert "settings.toml in the recording is damaged: the program's own is used" in told
    assert "--filter-config gives others" in told


def test_a_damaged_map_is_told_with_the_option_that_gives_one(recording, tmp_path, capsys):
    made, _ = recording
    (file,) = made.glob("*.mcap")
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(file.read_bytes().replace(b"<svg", b"<swg"))
    assert main(["replay", str(damaged), "--out", str(tmp_path / "out")]) == 1
    assert "the map in" in (told := capsys.readouterr().err)
    assert "is damaged; --map gives one" in told
    options = ["--map", "square", "--out", str(tmp_path / "out")]
    assert main(["replay", str(damaged), *options]) == 0


def test_other_settings_write_something_else(recording, tmp_path):
    made, _ = recording
    path = tmp_path / "few.toml"
    path.write_text("[localization.filter]\nmax_particles = 100\n")
    now = replay(made)
    few = replay(made, ReplayOptions(filter_config=path))
    assert (now.recorded_estimate == few.recorded_estimate)[~np.isnan(now.recorded_estimate)].all()
    assert not np.array_equal(now.estimated, few.estimated, equal_nan=True)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--speed", "0"], "--speed is 0; valid is 0.05 to 50"),
        (["--speed", "nan"], "--speed is nan; valid is 0.05 to 50"),
        (["--seed", "-1"], "--seed is -1; valid is"),
        (["--port", "99999"], "--port is 99999; valid is"),
        (["--speed", "2", "--out", "x"], "--speed has no effect with --out"),
        (["--map", "nowhere", "--out", "x"], "there is no field 'nowhere'"),
        (["--sensor-model", "gone.py:X", "--out", "x"], "there is no file"),
        (["--filter-config", "gone.toml", "--out", "x"], "gone.toml cannot be read"),
    ],
)
def test_wrong_options_are_refused_in_one_line(
    recording, capsys, tmp_path, monkeypatch, options, words
):
    monkeypatch.chdir(tmp_path)
    assert main(["replay", str(recording[0]), *options]) == 2
    complaint = capsys.readouterr().err
    assert words in complaint
    assert complaint.count("\n") == 1
    assert not (tmp_path / "x").exists()


def test_what_is_no_recording_is_named(capsys, tmp_path):
    path = tmp_path / "notes.txt"
    path.write_text("no recording")
    assert main(["replay", str(path), "--out", str(tmp_path / "x")]) == 1
    assert "is no MCAP file" in capsys.readouterr().err


def test_a_filter_config_changes_what_it_names_and_nothing_else(tmp_path):
    path = tmp_path / "few.toml"
    path.write_text("[localization.filter]\nmax_particles = 99\n[scanner]\nrays = 31\n")
    before = Config(seed=5)
    changed, names = with_filter_config(before, path)
    assert names == {"max_particles"}
    assert changed.localization.filter.max_particles == 99
    assert changed.scanner.rays == 31
    assert changed.seed == 5
    assert changed.localization.motion == before.localization.motion


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("seed = 3", "seed changes no replay; valid are the tables localization"),
        ("[localization.filter]\nmax_particels = 3", "max_particels"),
        ("[localization.filter]\nmax_particles = -3", "max_particles"),
        ("[localization", "is no TOML"),
    ],
)
def test_a_filter_config_that_cannot_be_used_is_refused(tmp_path, text, words):
    path = tmp_path / "wrong.toml"
    path.write_text(text)
    with pytest.raises(SettingError, match=words.replace("[", r"\[")):
        with_filter_config(Config(), path)


def test_the_settings_in_a_recording_are_toml_that_a_filter_config_may_repeat(recording):
    made, _ = recording
    from app.features.recordings.files.mcap_reader import open_recording

    content = tomllib.loads(open_recording(made).attachments["settings.toml"].decode())
    assert content["localization"]["filter"]["max_particles"] > 0
