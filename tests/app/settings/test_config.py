from dataclasses import dataclass, replace

import pytest

from app.command_line import parse
from app.engine.robots import robot_kind
from app.features.lab.sweep.sweep_file import Interval
from app.options import config_from
from app.settings.config import (
    NEW_NAMES,
    Config,
    as_table,
    by_path,
    from_table,
    load_config,
    with_settings,
)
from app.settings.provenance import settings_of
from robot.settings import SettingError, check_settings, setting


@dataclass(frozen=True)
class Lamps:
    """Settings of somebody's feature."""

    brightness: float = setting(0.8, "Of all lamps", low=0, high=1)
    colours: tuple[str, ...] = setting(("red",), "From left to right")

    def __post_init__(self):
        check_settings(self)


def load(tmp_path, text, **features):
    path = tmp_path / "config.toml"
    path.write_text(text, encoding="utf-8")
    return load_config(path, **features)


def test_an_empty_file_is_the_defaults(tmp_path):
    assert load(tmp_path, "") == Config()


def test_a_feature_of_another_package_has_a_table_of_its_own(tmp_path):
    text = "port = 9000\n[lamps]\nbrightness = 0.5"
    config = load(tmp_path, text, added={"lamps": Lamps()})
    assert config.port == 9000
    assert config.group("lamps", Lamps()) == Lamps(brightness=0.5)
    assert Config().group("lamps", Lamps(colours=("blue",))) == Lamps(colours=("blue",))
    assert load(tmp_path, text, ignored=("lamps",)) == replace(Config(), port=9000)
    hash(config)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[lamps]\nbrigthness = 0.5", r"\[lamps\] brigthness is unknown; valid .*brightness"),
        ("[lamps]\nbrightness = 2.0", r"\[lamps\] brightness is 2; valid is 0 to 1"),
        ("[lamps]\ncolours = 3", r"\[lamps\] colours is 3; valid is"),
        ("lamps = 3", "lamps is 3; valid is a table"),
    ],
)
def test_what_is_wrong_in_it_is_refused_when_it_is_read(tmp_path, text, told):
    with pytest.raises(SettingError, match=told):
        load(tmp_path, text, added={"lamps": Lamps()})


def test_a_feature_takes_no_table_of_the_programs_own(tmp_path):
    text = "[mapping]\nnothing = 1"
    with pytest.raises(SettingError, match=r"cannot have the settings \[mapping\]"):
        load(tmp_path, text, added={"mapping": Lamps()})
    with pytest.raises(SettingError, match=r"mapping\.nothing is unknown"):
        load(tmp_path, text, ignored=("mapping",))


def test_values_reach_their_place(tmp_path):
    config = load(
        tmp_path,
        """
        map = "town"
        port = 9000
        [drive]
        max_velocity = 1
        [localization.filter]
        min_particles = 200
        """,
    )
    assert (config.map, config.port) == ("town", 9000)
    assert config.drive.max_velocity == 1.0
    assert config.localization.filter.min_particles == 200


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("prot = 1", "prot is unknown; valid are .*port"),
        ("[added]\nlamps = 1", "added is unknown; valid are allowed_origins"),
        (
            "[localization.filter]\nmin_particle = 3",
            r"localization\.filter\.min_particle is unknown",
        ),
        ("[drive]\nmax_velocity = -1", "drive.max_velocity is -1 m/s; valid is 0 to 2 m/s"),
        ("port = 'http'", "port is 'http'; valid is a whole number"),
        ("port = true", "port is True"),
        ("port = 80.0", "port is 80.0; valid is a whole number"),
        ("[drive]\nmax_velocity = true", "drive.max_velocity is True; valid is a number"),
        ("[drive]\nmax_velocity = '1'", "drive.max_velocity is '1'; valid is a number"),
        ("map = 3", "map is 3; valid is a text"),
        ("map = 2026-01-01", r"map is datetime.date\(2026, 1, 1\); valid is a text"),
        ("drive = 2026-01-01", r"drive is datetime.date\(.*; valid is a table, as in \[drive\]"),
        ("allowed_origins = 'null'", "allowed_origins is 'null'; valid is a list"),
        ("allowed_origins = ['a', 1]", r"allowed_origins\[1\] is 1; valid is a text"),
        ("port = 'http'\n[drive]\nmin = 1", "drive.min is unknown"),
        ("drive = 3", "drive is 3; valid is a table"),
        ("port = ", "is no TOML"),
        ("[drive]\nmax_velocity = nan", "max_velocity is nan"),
        ("[drive]\nmax_velocity = inf", "max_velocity is inf"),
    ],
)
def test_a_wrong_key_or_value_is_refused_with_its_path_and_what_is_valid(tmp_path, text, told):
    with pytest.raises(SettingError, match=told):
        load(tmp_path, text)


def test_a_robot_that_there_is_not_is_refused_with_those_that_there_are(tmp_path):
    with pytest.raises(SettingError, match="robot is 'tank'; valid are auto, sim, kinematic, buil"):
        robot_kind(load(tmp_path, "robot = 'tank'"))


def test_settings_are_replaced_by_their_path():
    changed = with_settings(
        Config(), {"seed": 3, "localization.sensor.sigma_hit": 1e-3, "sim.camera.noise": 5}
    )
    assert (changed.seed, changed.localization.sensor.sigma_hit) == (3, 0.001)
    assert changed.sim.camera.noise == 5.0
    assert changed.localization.filter == Config().localization.filter
    assert with_settings(Config(), {}) == Config()


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        ({"localization.sensor.sigma_hut": 1.0}, "localization.sensor.sigma_hut is unknown; valid"),
        ({"localisation.sensor.sigma_hit": 1.0}, "localisation is unknown; valid are"),
        ({"localization.sensor.sigma_hit": 9.0}, "localization.sensor.sigma_hit is 9 m; valid is"),
        ({"seed.next": 1}, "seed is no table; next cannot be in it"),
        ({"drive.max_velocity.x.y": 1}, "drive.max_velocity is no table; x.y cannot be in it"),
        ({"seed": "one"}, "seed is 'one'; valid is a whole number"),
    ],
)
def test_a_wrong_path_or_value_is_refused(settings, told):
    with pytest.raises(SettingError, match=told):
        with_settings(Config(), settings)


def test_a_setting_without_a_default_has_to_be_given():
    assert from_table(Interval, {"low": 1, "high": 2}) == Interval(1.0, 2.0)
    with pytest.raises(SettingError, match="high is missing; valid is a number"):
        from_table(Interval, {"low": 1})


def test_a_table_is_taken_apart_and_put_together():
    flat = {"a": 1, "b.c": 2, "b.d.e": 3}
    assert by_path(as_table(flat, {})) == flat


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("camera_source = 'pi'", "camera_source is now camera.source"),
        ("[pictures]\nrotation = 180", "pictures is now camera$"),
        ("[physics]\nfriction = 1", "physics is now sim.physics"),
        ("[imperfections]", "imperfections is now sim.imperfections"),
        ("[camera]\nnoise = 5", "camera.noise is now sim.camera.noise"),
        ("[camera]\nframe_rate = 15\nlight = 0.5", "camera.light is now sim.camera.light"),
    ],
)
def test_a_name_of_before_is_refused_with_the_one_of_today(tmp_path, text, told):
    with pytest.raises(SettingError, match=told):
        load(tmp_path, text)


def test_each_name_of_today_is_one():
    known = settings_of(Config())
    for new in NEW_NAMES.values():
        assert any(f"{path}.".startswith(f"{new}.") for path in known), new


def test_the_camera_is_the_real_one_and_the_simulated_one_is_the_simulators(tmp_path):
    config = load(tmp_path, "[camera]\nsource = 'pi'\nframe_rate = 15\n[sim.camera]\nnoise = 5")
    assert (config.camera.source, config.camera.frame_rate) == ("pi", 15.0)
    assert (config.sim.camera.noise, config.sim.camera.frame_rate) == (5.0, 30.0)


def test_the_option_wins_over_the_source_in_the_file_and_leaves_the_rest(tmp_path):
    path = tmp_path / "config.toml"
    path.write_text("[camera]\nsource = 'pi'\nframe_rate = 15", encoding="utf-8")
    parsed = parse(["run", "--config", str(path), "--camera", "eye.sock"])
    config = config_from(parsed)
    assert (config.camera.source, config.camera.frame_rate) == ("eye.sock", 15.0)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(SettingError, match=r"nowhere\.toml cannot be read"):
        load_config(tmp_path / "nowhere.toml")


def test_a_huge_file_is_refused_before_it_is_parsed(tmp_path):
    with pytest.raises(SettingError, match="is too long; valid are up to 1000000 characters"):
        load(tmp_path, "#" * 1_000_001)


def test_a_number_of_thousands_of_hexadecimal_digits_is_refused(tmp_path):
    with pytest.raises(SettingError, match="a number is too long"):
        load(tmp_path, f"seed = 0x{'f' * 5000}")
