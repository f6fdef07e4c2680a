"""What plugs into the core: found, loaded, left out; one that is broken harms nobody."""

from __future__ import annotations

import dataclasses
import json
import os
import re
import signal
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from urllib.request import urlopen

import grimp
import pytest
from serving import ROOT, drive_until, serving

from app.command_line import SUBCOMMANDS, main, parse
from app.command_parser import CommandParser
from app.engine import plugging
from app.engine.plugging import plug_in
from app.engine.robot_kind import RobotKind
from app.feature import (
    Feature,
    Guest,
    Late,
    Panel,
    RunOptions,
    SettingOption,
    Subcommand,
)
from app.feature_search import FeatureError, Features, find_features
from app.features.own_models.named_models import NamedModels
from app.features.ros.topics import TOPICS
from app.options import config_from
from app.settings.config import Config, with_settings
from app.tools.doctor.command import check_features
from robot.driving.drive_controller import DriveSettings
from robot.hooks import FieldSource
from robot.localization.filter_kinds import OURS as FILTERS
from robot.settings import SettingError
from sim.engines import OURS as ENGINES

pytestmark = pytest.mark.slow

OURS = find_features()
NAMES = [
    "build_hat",
    "bullet",
    "calibration",
    "classroom",
    "control",
    "course",
    "faults",
    "field_editor",
    "grid_filter",
    "help",
    "interface",
    "kalman_filter",
    "kept_pose",
    "lab",
    "mapping",
    "misplaced_tape",
    "navigation",
    "own_models",
    "own_shadow",
    "picture_odometry",
    "plausibility",
    "recordings",
    "reverse_proxy",
    "ros",
    "run_table",
    "weighing",
]
CORE = 285, 33_000
"""Most modules and lines that the robot needs without features; fewer are better."""
BY_NAME = (
    *plugging.ROOMS_WITH_COMMANDS,
    plugging.ROOM_WITH_VALUES,
    plugging.ROOM_WITH_ROBOTS,
    *(kind.maker.partition(":")[0] for kind in (*FILTERS.values(), *ENGINES.values())),
)
"""Modules of the core that it names and does not import."""
LATE = {
    late.target: feature.name
    for feature in OURS.active
    for late in (
        *(subcommand.options for subcommand in feature.subcommands),
        *feature.routers,
        *feature.guests,
        *feature.gates,
        *feature.commands,
        *feature.values,
        *feature.messages,
        *feature.robots,
        *feature.filters,
        *feature.engines,
        *feature.compiled,
        *feature.builders,
        *feature.companions,
        *feature.models,
        *feature.checks,
        *feature.lens_files,
        *feature.fields,
        *(
            late
            for each in feature.run_options
            if isinstance(each, RunOptions)
            for late in (each.add, each.apply)
        ),
        feature.outlet,
    )
    if isinstance(late, Late)
} | {each.options.target: "" for each in SUBCOMMANDS}
WITHOUT = [word for feature in OURS.active for word in ("--without", feature.name)]
BROKEN = {
    "absent": ("nowhere.feature:FEATURE", "ModuleNotFoundError: No module named 'nowhere'"),
    "exits": ("exits:FEATURE", "SystemExit: 3 (exits.py:1)"),
    "raises": ("raises:FEATURE", "ZeroDivisionError: division by zero (raises.py:1)"),
    "other": ("other:FEATURE", "other:FEATURE is a int; valid is a Feature"),
    "renamed": ("renamed:FEATURE", "renamed:FEATURE calls itself paint"),
    "text": ("text:FEATURE", "TypeError: documents has 'x'; valid is a Path (text.py:2)"),
    "alone": ("alone:FEATURE", "TypeError: routers is Late(target='a:b'); valid is a tuple of"),
    "plain": ("plain:FEATURE", "TypeError: outlet is 'a:b'; valid is a function"),
    "names": ("names:FEATURE", "TypeError: checks has 'a:b'; valid is a function"),
    "bare": ("bare:FEATURE", "FileNotFoundError: the panel lamps has no script"),
    "runs": ("runs:FEATURE", "there is a command run already"),
    "sweeps": ("sweeps:FEATURE", "there is a command sweep already"),
}
SOURCES = {
    "exits": "raise SystemExit(3)",
    "raises": "1 / 0",
    "other": "FEATURE = 7",
    "renamed": "from app.feature import Feature\nFEATURE = Feature(name='paint', about='paints')",
    "alone": "from app.feature import *\n"
    "FEATURE = Feature(name='alone', about='', routers=Late('a:b'))",
    "plain": "from app.feature import *\nFEATURE = Feature(name='plain', about='', outlet='a:b')",
    "names": "from app.feature import *\n"
    "FEATURE = Feature(name='names', about='', checks=('a:b',))",
    "text": "from app.feature import Feature\n"
    "FEATURE = Feature(name='text', about='', documents=('x',))",
    "bare": "from app.feature import *\n"
    "FEATURE = Feature(name='bare', about='', panels=(Panel('lamps', '', Path('no.js')),))",
    "number": "from app.feature import *\n"
    "FEATURE = Feature(name='number', about='', routers=(abs,), checks=(lambda config: [3],))",
    "kinds": "from app.feature import *\n"
    "FEATURE = Feature(name='kinds', about='', robots=(lambda: [3],))",
    "mine": "from app.feature import Feature\nFEATURE = Feature(name='lab', about='mine')",
    "runs": "from app.feature import *\n"
    "FEATURE = Feature(name='runs', about='', subcommands=(Subcommand('run', '', id),))",
    "sweeps": "from app.feature import *\n"
    "FEATURE = Feature(name='sweeps', about='', subcommands=(Subcommand('sweep', '', id),))",
    "late": "from app.feature import *\ndef no(program):\n    raise KeyError('lamp')\n"
    "FEATURE = Feature(name='late', about='', routers=(no,), checks=(no,), "
    "subcommands=(Subcommand('lamp', 'lamps', Late('gone:add')),))",
}


@pytest.fixture
def put_back():
    before = plugging.plugged().features
    yield
    plug_in(before)


def installed(folder: Path, **targets: str) -> Path:
    """A package beside ours, as an installer leaves it."""
    about = folder / "strange-1.0.dist-info"
    about.mkdir(parents=True)
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: strange\nVersion: 1.0\n")
    lines = [f"{name} = {target}" for name, target in targets.items()]
    (about / "entry_points.txt").write_text("\n".join(("[brickpose.features]", *lines)))
    for name, source in SOURCES.items():
        (folder / f"{name}.py").write_text(source)
    return folder


def brickpose(*words: str, beside: Path | None = None) -> subprocess.CompletedProcess[str]:
    """The program as a user types it."""
    path = os.pathsep.join(map(str, filter(None, (beside, ROOT))))
    return subprocess.run(
        [sys.executable, "-m", "app", *words],
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


def test_ours_are_found_as_anybodys_are():
    assert [feature.name for feature in OURS.active] == NAMES
    assert OURS.failures == ()


@pytest.mark.parametrize("target", LATE)
def test_what_is_imported_late_is_there(target):
    module, _, name = target.partition(":")
    named = getattr(import_module(module), name)
    assert callable(named) or isinstance(named, tuple)
    feature = LATE[target]
    assert module.startswith(f"app.features.{feature}." if feature else "app.")


def test_features_of_others_that_cannot_be_loaded_are_named_and_the_rest_is_there(
    tmp_path, monkeypatch
):
    targets = {name: target for name, (target, _) in BROKEN.items()}
    monkeypatch.syspath_prepend(installed(tmp_path, **targets))
    features = find_features((), (each.name for each in SUBCOMMANDS))
    assert [feature.name for feature in features.active] == NAMES
    assert len(features.failures) == len(BROKEN)
    for name, (_, why) in BROKEN.items():
        begin = f"The feature {name} cannot be used: {why}"
        assert any(failure.startswith(begin) for failure in features.failures), features.failures


def test_two_packages_with_a_feature_of_one_name_are_both_named(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(installed(tmp_path, lab="mine:FEATURE"))
    features = find_features()
    assert [feature.name for feature in features.active] == NAMES
    assert features.failures == (
        "The feature lab of the package strange cannot be used: the package brickpose has one of "
        "that name; uninstall one of them, or rename its entry point.",
    )


def test_a_feature_whose_parts_fail_harms_no_other(tmp_path, monkeypatch, capsys):
    monkeypatch.syspath_prepend(installed(tmp_path, late="late:FEATURE", number="number:FEATURE"))
    features = find_features(["number"])
    assert features.failures == ()
    _, failures = features.routers(None)
    assert failures == [
        "The feature late cannot be used: KeyError: 'lamp' (late.py:3); --without late leaves it "
        "out."
    ]
    problems = [
        finding.message
        for finding in check_features(Config(), features)
        if finding.level == "problem"
    ]
    assert problems == failures
    number = find_features(["late"])
    assert number.routers(-2)[1][0].startswith(
        "The feature number cannot be used: TypeError: it makes a int; valid is a APIRouter"
    )
    assert "valid is a Finding" in list(number.findings(Config()))[-1].message
    assert main(["lamp"]) == 1
    assert "The feature late cannot be used: ModuleNotFoundError" in capsys.readouterr().err


@pytest.mark.real_time
def test_a_robot_drives_though_features_are_broken_and_the_page_names_them(tmp_path, monkeypatch):
    beside = installed(tmp_path, raises="raises:FEATURE", late="late:FEATURE")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join((str(beside), str(ROOT))))
    with serving("--robot", "kinematic") as server, server.live() as socket:
        begin = drive_until(socket, 0.1, lambda now: now["truth"] is not None)["truth"]
        now = drive_until(socket, 0.1, lambda now: now["truth"]["x"] > begin["x"] + 0.05)
        with urlopen(f"{server.url}/api/health", timeout=10) as answer:
            health = json.load(answer)
    assert health["status"] == "degraded"
    for words in ("The feature raises cannot", "The feature late cannot"):
        assert words in health["detail"]
        assert any(words in problem for problem in now["problems"])


def test_a_broken_feature_is_a_line_of_the_doctor_and_of_an_unknown_command(tmp_path):
    beside = installed(tmp_path, raises="raises:FEATURE", kinds="kinds:FEATURE")
    done = brickpose("doctor", "--robot", "kinematic", beside=beside)
    broken = "The feature kinds cannot be used: TypeError: a robot is 3; valid is a RobotKind"
    assert f"problem  {broken}" in done.stdout
    run = brickpose("run", "--robot", "kinds", "--port", "0", beside=beside)
    assert "robot is 'kinds'; valid are auto, sim, kinematic, buildhat. " in run.stderr
    assert broken in run.stderr
    assert f"ok       Features: {', '.join(NAMES)}\n" in done.stdout
    assert "problem  The feature raises cannot be used: ZeroDivisionError" in done.stdout
    assert done.returncode == 1
    done = brickpose("paint", beside=beside)
    assert done.returncode == 2
    assert "The feature raises cannot be used" in done.stderr


@pytest.mark.parametrize(
    ("hooks", "words"),
    [
        (
            {"run_options": (RunOptions(lambda run: run.add_argument("--seed"), id),)},
            "ArgumentError: argument --seed: conflicting option string",
        ),
        ({"settings": dict}, "its settings are a dict; valid is a dataclass"),
        ({"guests": (lambda config: [3],)}, "it makes a int; valid is a Guest"),
        ({"documents": (ROOT / "docs" / "design.md",)}, "there is a document 'design.md' already"),
        ({"documents": (Path("gone.md"),)}, "No such file or directory: 'gone.md'"),
        (
            {"models": (lambda config, field: [NamedModels(field, sensors={"beam": id})],)},
            "there is a model 'beam' already",
        ),
        (
            {"robots": (lambda: [RobotKind(name="sim", about="", build=id)],)},
            "there is a robot 'sim' already",
        ),
        ({"topics": (lambda: [TOPICS[0]],)}, "there is a topic 'scan' already"),
    ],
)
def test_the_doctor_names_what_a_start_would_refuse(hooks, words, put_back):
    lamps = Feature(name="lamps", about="lamps on the robot", **hooks)
    features = plug_in(OURS.adding(lamps))
    problems = [
        finding.message
        for finding in check_features(Config(), features)
        if finding.level == "problem"
    ]
    assert len(problems) == 1
    assert problems[0].startswith("The feature lamps cannot be used: ")
    assert words in problems[0]


def test_settings_with_the_name_of_ours_are_a_problem(put_back):
    drive = Feature(name="drive", about="", settings=DriveSettings)
    problems = [str(each) for each in check_features(Config(), plug_in(OURS.adding(drive)))]
    assert any("a feature cannot have the settings [drive]" in each for each in problems)


def test_the_doctor_says_what_others_add(put_back):
    lamps = Feature(name="lamps", about="lamps on the robot")
    features = dataclasses.replace(OURS.adding(lamps), packages={"lamps": "brickpose-lamps"})
    said = [str(each) for each in check_features(Config(), plug_in(features))]
    assert "ok       lamps, of the package brickpose-lamps: lamps on the robot" in said
    assert any("kinematic (without, its wheels roll as if on rails)" in each for each in said)


def test_the_doctor_goes_on_without_the_robot_that_there_is_not():
    done = brickpose("doctor", "--robot", "snial")
    assert "problem  robot is 'snial'; valid are auto, sim" in done.stdout
    assert "ok       Features: " in done.stdout
    assert done.returncode == 1


@pytest.mark.parametrize(
    ("words", "left_out"),
    [
        (("run", "--without", "lab"), ("lab",)),
        (("--without", "lab", "run"), ("lab",)),
        (("run", "--without=lab", "--without", "course"), ("lab", "course")),
        (("calibrate", "undo", "--without", "course"), ("course",)),
        (("evaluate", "models", "--without", "course", "--seeds", "2"), ("course",)),
        (("run",), ()),
    ],
)
def test_a_feature_is_left_out_on_every_command(words, left_out):
    parsed = parse(words)
    assert parsed.features.left_out == left_out
    assert not {feature.name for feature in parsed.features.active} & set(left_out)
    assert "without" not in vars(parsed)


@pytest.mark.parametrize("command", [each.name for each in SUBCOMMANDS] + ["learn", "sweep"])
def test_the_help_of_every_command_tells_how_to_leave_one_out(command, capsys):
    with pytest.raises(SystemExit):
        parse([command, "--help"])
    assert "--without NAME" in capsys.readouterr().out


def test_a_command_of_a_feature_that_is_left_out_is_none_and_the_error_says_why(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["sweep", "x.toml", "--without", "lab"])
    assert ended.value.code == 2
    assert "invalid choice: 'sweep'" in (told := capsys.readouterr().err)
    assert told.endswith("; without lab\n")


@pytest.mark.parametrize("command", ["export", "run"])
def test_a_field_of_a_feature_that_is_left_out_is_none_for_every_command(command, tmp_path):
    words = ["ros2", str(tmp_path / "out")] if command == "export" else ["--port", "0"]
    done = brickpose(command, *words, "--map", "generated-17", "--without", "lab")
    assert done.returncode == 2
    assert "there is no field 'generated-17'; valid are " in done.stderr
    assert done.stderr.endswith("; without lab\n")
    assert not (tmp_path / "out").exists()


def test_a_file_of_settings_leaves_features_out(tmp_path, capsys):
    file = tmp_path / "small.toml"
    file.write_text('[features]\nwithout = ["course"]\n')
    parsed = parse(["run", "--config", str(file), "--without", "lab"])
    assert set(parsed.features.left_out) == {"course", "lab"}
    file.write_text("[features]\nwithout = 3\n")
    assert main(["run", "--config", str(file), "--port", "0"]) == 2
    assert "features.without is 3; valid is a list" in capsys.readouterr().err


@pytest.mark.parametrize("how", ["typed", "in a file"])
def test_an_unknown_feature_is_refused_with_those_that_exist(how, tmp_path, capsys):
    file = tmp_path / "small.toml"
    file.write_text('[features]\nwithout = ["moon"]\n')
    words = ["--without", "moon"] if how == "typed" else ["--config", str(file)]
    assert main(["run", "--port", "0", *words]) == 2
    told = capsys.readouterr().err
    valid = ", ".join(NAMES)
    assert told == f"brickpose: there is no feature moon to leave out; valid are {valid}\n"
    with pytest.raises(SettingError):
        find_features(["Lab"])


def test_nothing_that_run_imports_without_features_belongs_to_one():
    graph = grimp.build_graph("app", "robot", "sim")
    closure, seen = ["app.__main__", "app.page.run_options", *BY_NAME], {""}
    while closure:
        module = closure.pop()
        if module not in seen and module in graph.modules:
            seen.add(module)
            closure += [*graph.find_modules_directly_imported_by(module), module.rpartition(".")[0]]
    assert {"app.engine.engine", "app.page.server", "sim.mujoco_world"} <= seen
    assert not [module for module in seen if module.startswith("app.features")]
    files = [ROOT / f"{module.replace('.', '/')}.py" for module in seen & graph.modules]
    lines = sum(len(file.read_text("utf-8").splitlines()) for file in files if file.is_file())
    assert (len(seen) <= CORE[0], lines <= CORE[1]) == (True, True), (len(seen), lines)


@pytest.mark.real_time
def test_run_without_features_loads_nothing_of_them():
    code = (
        "import atexit, sys; from app.command_line import main; "
        "atexit.register(lambda: print(sorted(m for m in sys.modules if 'features' in m))); "
        f"sys.exit(main(['run', '--robot', 'sim', '--port', '0', *{WITHOUT!r}]))"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code], cwd=ROOT, stdout=subprocess.PIPE, text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    for line in process.stdout:
        address = re.search(r"http://\S+:\d+", line)
        if address:
            break
    with urlopen(f"{address[0]}/api/health", timeout=60) as answer:
        assert json.load(answer)["status"] in ("ok", "degraded")
    process.send_signal(signal.SIGTERM)
    printed, _ = process.communicate(timeout=30)
    assert process.returncode == 0
    assert printed.splitlines()[-1] == "[]"


def test_help_imports_nothing_that_a_command_needs():
    code = (
        "import sys; from contextlib import suppress; from app.command_line import main\n"
        "with suppress(SystemExit): main(['--help'])\n"
        "print(*sys.modules, sep='\\n', file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, text=True, capture_output=True, check=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    loaded = set(done.stderr.split())
    assert "app.features.lab.feature" in loaded
    assert not loaded & {"numpy", "pydantic", "fastapi", "numba", "app.settings.config"}
    for feature in OURS.active:
        for subcommand in feature.subcommands:
            assert subcommand.name in done.stdout


@pytest.mark.parametrize(
    "record", [Feature, FieldSource, Guest, Panel, RunOptions, SettingOption, Subcommand]
)
def test_every_hook_is_documented(record):
    document = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")
    for field in dataclasses.fields(record):
        assert f"\n| `{field.name}` |" in document, field.name


def test_an_option_of_a_feature_that_is_left_out_is_refused(capsys):
    with pytest.raises(SystemExit) as left:
        parse(["run", "--without", "recordings", "--record", "here"])
    assert left.value.code == 2
    assert "unrecognized arguments: --record here; without recordings" in capsys.readouterr().err
    assert config_from(parse(["run", "--record", "here"])).recording.folder == "here"


@pytest.mark.parametrize("words", [("run",), ("replay", "drive")])
def test_without_own_models_there_are_no_options_for_them(words, capsys):
    given = ("--sensor-model", "mine.py:Mine", "--models", "mine")
    parsed = parse([*words, *given])
    assert (parsed.sensor_model, parsed.models) == ("mine.py:Mine", "mine")
    assert config_from(parsed).sensor_model == "mine.py:Mine"
    with pytest.raises(SystemExit):
        parse([*words, *given, "--without", "own_models"])
    assert "unrecognized arguments: --sensor-model" in capsys.readouterr().err


def test_options_of_a_feature_that_fail_name_it():
    def fail(*_):
        raise KeyError("lamp")

    for options in (RunOptions(add=fail, apply=fail), RunOptions(lambda parser: None, fail)):
        feature = Feature(name="lamps", about="", run_options=(options,), settings=fail)
        features = Features((feature,))
        with pytest.raises(FeatureError, match="The feature lamps cannot be used: KeyError"):
            features.add_run_options(CommandParser())
            features.with_run_options(Config(), {})
        with pytest.raises(FeatureError, match="The feature lamps cannot be used: KeyError"):
            _ = features.settings


def test_guests_of_a_feature_come_in_and_those_that_are_none_name_it():
    guest = Guest("Lamp desk", "/lamps")
    lamps = Feature(name="lamps", about="", guests=(lambda config: [guest],))
    assert Features((lamps,)).guests(Config()) == (guest,)
    assert OURS.guests(Config()) == ()
    (foxglove,) = OURS.guests(with_settings(Config(), {"ros2.foxglove": True}))
    assert foxglove.path == "/foxglove"
    broken = Feature(name="lamps", about="", guests=(lambda config: ["/lamps"],))
    with pytest.raises(FeatureError, match="makes a str; valid is a Guest"):
        Features((broken,)).guests(Config())
