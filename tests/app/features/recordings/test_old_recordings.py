"""A recording from before there was a table [sim] is read with its settings of then."""

import tomllib
from dataclasses import replace
from types import SimpleNamespace

import pytest

from app.features.recordings.attachments import SETTINGS, as_toml
from app.features.recordings.files.recorded import RecordingError
from app.features.recordings.replay.parts import RecordedParts, with_new_names
from app.settings.config import Config, from_table, with_settings

OLD = """
robot = "sim"
seed = 7
camera_source = "pi"

[drive]
max_velocity = 0.2

[localization]

[localization.filter]
min_particles = 700

[pictures]
frame_rate = 20.0
rotation = 180

[camera]
frame_rate = 15.0
exposure = 0.02
noise = 5.0

[physics]
friction = 0.5

[imperfections]
slip_sd = 0.1
robot = 3
"""

TODAY = {
    "robot": "sim",
    "seed": 7,
    "drive.max_velocity": 0.2,
    "localization.filter.min_particles": 700,
    "camera.source": "pi",
    "camera.frame_rate": 20.0,
    "camera.rotation": 180,
    "sim.camera.frame_rate": 15.0,
    "sim.camera.exposure": 0.02,
    "sim.camera.noise": 5.0,
    "sim.physics.friction": 0.5,
    "sim.imperfections.slip_sd": 0.1,
    "sim.imperfections.robot": 3,
}


def parts_with(text):
    attachments = {SETTINGS: text.encode()}
    return RecordedParts.of(SimpleNamespace(attachments=attachments, metadata={}, path="made.mcap"))


def test_names_of_before_become_those_of_today():
    assert from_table(Config, with_new_names(tomllib.loads(OLD))) == with_settings(Config(), TODAY)


def test_names_of_today_stay():
    config = with_settings(Config(), TODAY)
    assert from_table(Config, with_new_names(tomllib.loads(as_toml(config)))) == config


def test_an_old_recording_is_read():
    parts = parts_with(OLD)
    assert parts.has_settings
    assert (parts.config.seed, parts.config.drive.max_velocity) == (7, 0.2)
    assert parts.config.localization.filter.min_particles == 700


def test_settings_of_features_are_those_of_the_recording():
    config = replace(Config(), added={"lamps": {"bright": 0.5}})
    assert parts_with(as_toml(config)).config.added == {"lamps": {"bright": 0.5}}


@pytest.mark.parametrize("wrong", ["drive = 3", "[drive]\nmax_velocity = 'fast'", "seed ="])
def test_settings_that_are_none_are_refused_with_the_recording(wrong):
    with pytest.raises(RecordingError, match=r"made\.mcap cannot be used"):
        parts_with(wrong)
