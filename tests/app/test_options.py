"""Options that set settings: each sets its own, in its type, with its help, and no other."""

import argparse
import dataclasses
import functools
from dataclasses import dataclass

import pytest

from app.command_line import parse
from app.command_parser import CommandParser
from app.feature import Feature, SettingOption
from app.feature_search import FeatureError, Features
from app.options import SETTINGS, add_setting, config_from
from app.settings.config import Config, by_path
from robot.settings import SettingError, check_settings, setting

TYPED = {bool: (), int: ("4711",), str: ("/typed",)}
FEATURES = parse(["run"]).features
OURS = (
    *SETTINGS.values(),
    *(
        option
        for feature in FEATURES.active
        for option in feature.run_options
        if isinstance(option, SettingOption)
    ),
)
ADDED = {"reverse_proxy.root_path": ""}
"""What settings of features are, if not switches."""
UNTYPED = "lamps.rows", "lamps.shining"
LAMPS = ("bright", "colour", "count", "share")


@dataclass(frozen=True)
class LampSettings:
    """Settings of a feature of another package."""

    bright: bool = setting(False, "Full light")
    colour: str = setting("red", "Colour of the lamps", choices=("red", "green"))
    count: int = setting(3, "LEDs of each lamp", low=1, high=9)
    share: float = setting(0.5, "How long they shine, of 100 % of the time", unit="s/s", low=0)
    rows: tuple[int, ...] = setting((), "Which rows")
    shining: bool = setting(True, "Shine")

    def __post_init__(self):
        check_settings(self)


def lamps(*options):
    feature = Feature(name="lamps", about="", settings=LampSettings, run_options=options)
    return Features((feature,))


def typed(features, *words, replays=False):
    parser = CommandParser()
    features.add_run_options(parser, replays=replays)
    parsed = parser.parse_args(words)
    parsed.features = features
    return parsed


def flat(config):
    return by_path(dataclasses.asdict(config))


@pytest.mark.parametrize("option", OURS, ids=lambda option: option.key)
def test_an_option_sets_its_setting_and_no_other(option):
    default = flat(Config()).get(option.path, ADDED.get(option.path, False))
    words = TYPED[type(default)]
    config = config_from(parse(["run", f"--{option.key.replace('_', '-')}", *words]))
    changed = {name for name, value in flat(config).items() if flat(Config()).get(name) != value}
    assert changed - {"added"} == {option.path} or changed == {f"added.{option.path}"}
    value = functools.reduce(
        lambda group, name: group[name] if isinstance(group, dict) else getattr(group, name),
        option.path.split("."),
        config.added if option.path.split(".")[0] in config.added else config,
    )
    assert value == (type(default)(*words) if words else True)


def test_what_is_not_typed_stays_as_the_file_says(tmp_path):
    file = tmp_path / "robot.toml"
    file.write_text('port = 9000\n[ros2]\ndds = true\n[start_pose]\npose_file = "here.toml"\n')
    config = config_from(parse(["run", "--config", str(file), "--foxglove", "--restore-pose"]))
    assert (config.port, config.ros2.dds, config.ros2.foxglove) == (9000, True, True)
    assert (config.start_pose.pose_file, config.start_pose.restore_pose) == ("here.toml", True)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--port", "99999"), "^port is 99999; valid is 0 to 65535$"),
        (("--seed", "-1"), "^seed is -1; valid is 0 to 4294967295$"),
    ],
)
def test_a_value_out_of_range_is_refused_with_what_is_valid(words, message):
    with pytest.raises(SettingError, match=message):
        config_from(parse(["run", *words]))


def test_a_value_of_another_type_is_refused_by_the_option(capsys):
    with pytest.raises(SystemExit) as left:
        parse(["run", "--port", "many"])
    assert left.value.code == 2
    assert "argument --port: invalid int value: 'many'" in capsys.readouterr().err


def test_a_feature_has_options_for_its_own_settings(capsys):
    features = lamps(*(SettingOption(f"lamps.{name}", LampSettings) for name in LAMPS))
    given = ("--bright", "--colour", "green", "--count", "5", "--share", "0.25")
    config = config_from(typed(features, *given))
    assert config.group("lamps", LampSettings()) == LampSettings(True, "green", 5, 0.25)
    assert config_from(typed(features)) == Config()
    with pytest.raises(SystemExit):
        typed(features, "--help")
    shown = " ".join(capsys.readouterr().out.split())
    assert "--colour COLOUR colour of the lamps (default: red)" in shown
    assert "--bright full light --colour" in shown
    assert "how long they shine, of 100 % of the time [s/s] (default: 0.5)" in shown


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--count", "10"), r"^\[lamps\] count is 10; valid is 1 to 9$"),
        (("--colour", "blue"), r"^\[lamps\] colour is 'blue'; valid are red, green$"),
    ],
)
def test_a_feature_refuses_what_its_own_settings_refuse(words, message):
    features = lamps(*(SettingOption(f"lamps.{name}", LampSettings) for name in LAMPS))
    with pytest.raises(SettingError, match=message):
        config_from(typed(features, *words))


def test_an_option_keeps_what_a_file_says_in_the_same_table():
    features = lamps(SettingOption("lamps.count", LampSettings, "N", name="leds_a_lamp"))
    config = features.with_run_options(
        Config(added={"lamps": {"colour": "green"}}), {"leds_a_lamp": 7}
    )
    assert config.group("lamps", LampSettings()) == LampSettings(colour="green", count=7)


@pytest.mark.parametrize("path", ["lamps.heat", "lamps", "ros2.heat", "rso2.dds", *UNTYPED])
def test_an_option_of_no_setting_names_feature_and_path(path):
    for settings in (None, LampSettings):
        with pytest.raises(FeatureError, match=f"feature lamps .* no option can set {path}; valid"):
            lamps(SettingOption(path, settings)).add_run_options(CommandParser())


def test_a_replay_has_the_options_that_say_so():
    features = lamps(
        SettingOption("lamps.count", LampSettings, replays=True),
        SettingOption("lamps.bright", LampSettings),
    )
    assert typed(features, "--count", "4", replays=True).count == 4
    with pytest.raises(SystemExit):
        typed(features, "--bright", replays=True)


def test_the_help_of_an_option_begins_small_and_has_the_default():
    parser = argparse.ArgumentParser()
    add_setting(parser, SETTINGS["host"])
    assert parser._actions[-1].help == "address to listen on; 0.0.0.0 is all (default: 127.0.0.1)"


@pytest.mark.parametrize(
    ("words", "port"), [((), "found"), (("auto",), "found"), (("/dev/ttyUSB0",), "/dev/ttyUSB0")]
)
def test_motors_are_stopped_at_the_port_that_is_meant(words, port, monkeypatch):
    stopped = []
    monkeypatch.setattr("robot.hat.serial_port.find_device", lambda: "found")
    monkeypatch.setattr("robot.hat.serial_port.stop_motors", stopped.append)
    parsed = parse(["stop-motors", *(("--serial-port", *words) if words else ())])
    assert parsed.command(parsed) == 0
    assert stopped == [port]
