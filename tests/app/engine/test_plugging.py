"""Commands and values of features: in the engine's tables, or named as what is wrong."""

import re
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from engine_runs import EIGHT, kinematic, run
from places import ROOT
from pydantic import create_model
from simulators import require_engine

from app.engine.added_models import AddedModels, Clearing, ModelChoice
from app.engine.build import build_on_field, build_program
from app.engine.command_row import CommandRow
from app.engine.commands import parse, row_of, table
from app.engine.plugging import models_of, plug_in, plugged
from app.engine.robot_kind import RobotKind
from app.engine.simulated_robots import build_kinematic
from app.engine.start import Start
from app.engine.value import Value
from app.engine.values import values
from app.feature import Feature
from app.feature_search import FeatureError, Features, find_features
from app.features.interface.docs_page import docs_page
from app.messages.commands import AckMessage, PlaceCommand
from app.messages.message import CommandMessage, Message
from app.messages.schema import schema
from app.messages.telemetry import PoseMessage
from app.settings.config import MAPS, Config
from app.settings.field_names import field_named, listed_fields
from app.tools.typescript import render
from robot.description.lens_file import read_lens
from robot.description.spec import SPIKE, RobotSpec, SpecError
from robot.errors import CommandError, PackageError
from robot.fields.field import FieldError
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.hooks import FieldSource
from robot.lens_files.writing import FORMATS
from robot.localization.estimate import Hypothesis
from robot.localization.filter_kinds import FilterKind
from robot.localization.kalman_filter import KalmanFilter
from robot.localization.parameters import FilterParameters, LocalizationParameters
from robot.settings import SettingError
from sim.engines import ENGINES, PhysicsEngine, choose_engine
from sim.mujoco_world import MujocoWorld
from sim.simulated import SimSettings


class BlinkCommand(CommandMessage):
    """A command of nobody else."""

    type: Literal["blink"]
    times: int


class LampMessage(Message):
    """A lamp."""

    brightness: float
    """How bright it is."""


class OtherStopCommand(CommandMessage):
    """Has a type that is taken."""

    type: Literal["stop"]


def named_as(known, kind=""):
    """Another class of messages with the name of one of ours."""
    if not kind:
        return create_model(known.__name__, __base__=Message)
    return create_model(known.__name__, __base__=CommandMessage, type=(Literal["lamp"], ...))


def around(inside):
    return create_model("LampsMessage", __base__=Message, lamps=(list[inside] | None, None))


@pytest.fixture(autouse=True)
def put_back():
    """What takes part is as it was, afterwards."""
    before = plugged().features
    yield
    plug_in(before)


def lamps(**hooks):
    return plugged().features.adding(Feature(name="lamps", about="lamps on the robot", **hooks))


def test_a_command_of_a_feature_is_read_and_carried_out_as_all_others():
    before = len(table())
    assert plug_in(lamps(commands=(lambda: (CommandRow(BlinkCommand),),))).failures == ()
    assert len(table()) == before + 1
    assert row_of(parse('{"type": "blink", "times": 2}')).command is BlinkCommand
    with pytest.raises(CommandError, match=r"blink.times"):
        parse('{"type": "blink", "times": "twice"}')
    with pytest.raises(
        CommandError, match=r"^blink.colour is unknown; valid are 'id', 'sent', 'type', 'times'$"
    ):
        parse('{"type": "blink", "times": 2, "colour": 3}')


def test_messages_and_commands_of_a_feature_are_described_for_people_and_for_the_page():
    hooks = {
        "messages": (lambda: [LampMessage],),
        "commands": (lambda: [CommandRow(BlinkCommand)],),
    }
    plug_in(lamps(**hooks))
    page = docs_page({"info": {"title": "BrickPose"}, "paths": {}})
    types = render(schema(plugged().all_messages))
    for name in ("LampMessage", "BlinkCommand"):
        assert f'<h2 id="{name}">' in page
        assert f"export interface {name} {{" in types
    assert "How bright it is." in page
    assert "  | BlinkCommand\n" in types


def test_a_value_of_a_feature_is_shown_last():
    plug_in(lamps(values=(lambda: [Value("lamps", lambda _: 3)],)))
    assert [value.name for value in values()][-1] == "lamps"


def engine(name, loader="m:f"):
    world = f"{__name__}:StrangersWorld"
    return PhysicsEngine(name, package="numpy", module="numpy", maker=world, loader=loader)


class Lamps(AddedModels):
    """Offers sensor models by these names."""

    def __init__(self, *names):
        super().__init__()
        self._choice = ModelChoice(sensors=names)

    @property
    def choice(self):
        return self._choice


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (lambda: [Lamps("beam")], "ValueError: there is a model 'beam' already"),
        (lambda: [Lamps("differential")], "ValueError: there is a model 'differential' already"),
        (lambda: ["beam"], "AttributeError: 'str' object has no attribute 'choice'"),
        (lambda: 1 / 0, "ZeroDivisionError"),
    ],
)
def test_models_that_cannot_be_had_are_named_and_the_robot_drives(made, words):
    plug_in(lamps(models=(lambda config, field: made(),)))
    program = kinematic()
    shown = run(program, 0.3, EIGHT)[-1]
    (problem,) = shown.problems.present
    assert problem.startswith(f"The feature lamps cannot be used: {words}")
    assert (shown.filter.models, shown.mode) == (ModelChoice(), "figure_eight")


def test_models_of_several_features_are_one_list():
    plug_in(lamps(models=(lambda config, field: [Lamps("bright"), Lamps("dim")],)))
    assert kinematic().given == ModelChoice(sensors=("bright", "dim"))


def test_scans_are_cleared_by_view_then_motion_then_map_whatever_the_features_are_called():
    cleared = []

    def models(clearing):
        class Clearer(AddedModels):
            def cleared(self, scan, odometry):
                cleared.append(self.clearing)
                return scan

        Clearer.clearing = clearing
        return Clearer()

    made = [models(clearing) for clearing in (Clearing.MAP, Clearing.VIEW, Clearing.MOTION)]
    plug_in(lamps(models=(lambda config, field: made,)))
    run(kinematic(), 0.5)
    assert cleared[:3] == [Clearing.VIEW, Clearing.MOTION, Clearing.MAP]


def test_our_features_clear_scans_in_an_order_in_which_each_gets_what_it_reckons_with():
    plug_in(find_features())
    added = models_of(Config(), load_field("stub", MAPS))
    owners = [type(models).__module__.split(".")[2] for models in added]
    clearers = [name for name in owners if name in ("own_shadow", "plausibility", "misplaced_tape")]
    assert clearers == ["own_shadow", "plausibility", "misplaced_tape", "misplaced_tape"]


def test_a_run_begins_where_a_feature_says_and_its_mistake_is_told():
    there = Hypothesis(1.0, Pose2(0.2, -0.1, 1.0), np.diag([1e-6, 1e-6, 1e-6]))
    plug_in(lamps(starts=(lambda config, field: Start((there,)),)))
    shown = run(kinematic(), 0.02, EIGHT)[-1]
    assert shown.filter.cloud.poses.mean(axis=0) == pytest.approx([0.2, -0.1, 1.0], abs=0.01)
    plug_in(lamps(starts=(lambda config, field: 1 / 0, lambda config, field: None)))
    program = kinematic()
    shown = run(program, 0.02, EIGHT)[-1]
    (problem,) = shown.problems.record
    assert problem.message.startswith("The feature lamps cannot be used: ZeroDivisionError")
    assert shown.truth.distance_to(program.field.start) < 0.01


def test_without_features_there_are_our_models_alone():
    plug_in(Features())
    program = kinematic(sensor_model="gone.py:Gone")
    assert program.given == ModelChoice()
    assert run(program, 0.3)[-1].filter.fault is None


@pytest.mark.parametrize(
    ("hooks", "words"),
    [
        ({"commands": (lambda: [CommandRow(OtherStopCommand)],)}, "for the command 'stop'"),
        ({"commands": (lambda: [BlinkCommand],)}, "valid is a CommandRow"),
        ({"commands": (lambda: [CommandRow(CommandMessage)],)}, "a CommandMessage with a type"),
        ({"commands": (lambda: [CommandRow(Value)],)}, "Value is no command"),
        ({"values": (lambda: [Value("mode", lambda _: 1)],)}, "a value 'mode' already"),
        ({"values": (lambda: ["mode"],)}, "valid is a Value"),
        ({"messages": (lambda: [named_as(AckMessage)],)}, "a message AckMessage already"),
        ({"messages": (lambda: [around(named_as(PoseMessage))],)}, "a message PoseMessage already"),
        (
            {"commands": (lambda: [CommandRow(named_as(PlaceCommand, "lamp"))],)},
            "a message PlaceCommand already",
        ),
        ({"messages": (lambda: ["lamp"],)}, "valid is a class of messages"),
        ({"fields": (lambda: ["square"],)}, "valid is a FieldSource"),
        ({"filters": (lambda: ["mine"],)}, "valid is a FilterKind"),
        ({"filters": (lambda: [FilterKind("grid", "m:f")],)}, "a filter 'grid' already"),
        ({"filters": (lambda: [FilterKind("kalman", "m:f")],)}, "a filter 'kalman' already"),
        ({"engines": (lambda: ["mine"],)}, "valid is a PhysicsEngine"),
        ({"engines": (lambda: [engine("bullet")],)}, "a physics engine 'bullet' already"),
        ({"engines": (lambda: [engine("mujoco")],)}, "a physics engine 'mujoco' already"),
        ({"engines": (lambda: [engine("auto")],)}, "a physics engine 'auto' already"),
        ({"commands": (lambda: 1 / 0,)}, "ZeroDivisionError"),
        (
            {"commands": (lambda: [CommandRow(BlinkCommand)],), "values": (lambda: ["mode"],)},
            "valid is a Value",
        ),
    ],
)
def test_what_cannot_be_used_is_named_and_changes_nothing(hooks, words):
    before, shown = table(), values()
    (failure,) = plug_in(lamps(**hooks)).failures
    assert words in failure
    assert "--without lamps" in failure
    assert (table(), values()) == (before, shown)


def test_fields_and_lenses_of_a_feature_are_found_and_its_mistakes_name_it(tmp_path):
    made = load_field("square", MAPS)
    hooks = {
        "fields": (
            lambda: [FieldSource("moon", "moon".__eq__, lambda _: made, ("moon",))],
            lambda: [FieldSource(".tape", lambda name: name.endswith(".tape"), abs, files=True)],
        ),
        "lens_files": (lambda path: 1 / 0,),
    }
    assert plug_in(lamps(**hooks)).failures == ()
    assert load_field("moon", Path("nowhere")) is made
    assert "moon" in listed_fields(tmp_path)
    assert field_named("moon", tmp_path) == "moon"
    with pytest.raises(FieldError, match=r"moon, or an \.svg or .*\.tape file"):
        load_field("sun", MAPS)
    with pytest.raises(CommandError, match="there is no field"):
        field_named("own.tape", tmp_path)
    with pytest.raises(FeatureError, match="The feature lamps cannot be used: TypeError"):
        load_field("own.tape", MAPS)
    (tmp_path / "lens.yaml").write_text("nothing: known")
    with pytest.raises(FeatureError, match="The feature lamps cannot be used: ZeroDivisionError"):
        read_lens(tmp_path / "lens.yaml")


def test_without_calibration_a_foreign_lens_beside_a_description_is_refused_by_name(tmp_path):
    lens = RobotSpec.load().lens
    urdf = SPIKE.read_text("utf-8").replace(">pi_camera.yaml<", ">lens.yaml<")
    (tmp_path / "robot.urdf").write_text(urdf, "utf-8")
    (tmp_path / "lens.yaml").write_text(FORMATS["opencv"].write(lens))
    plug_in(find_features())
    read = RobotSpec.load(tmp_path / "robot.urdf").lens
    np.testing.assert_array_equal(read.matrix, lens.matrix)
    np.testing.assert_array_equal(read.distortion, lens.distortion)
    plug_in(find_features(["calibration"]))
    with pytest.raises(SpecError, match=r"lens\.yaml: .*camera_info.*; without calibration$"):
        RobotSpec.load(tmp_path / "robot.urdf")


def test_the_companion_of_the_document_counts_pictures_without_tape():
    document = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")
    code: dict[str, Any] = {}
    exec(re.search(r"```python\n(# blank/counting.py.*?)```", document, re.S)[1], code)
    hooks = {"companions": (code["companions"],), "values": (code["values"],)}
    blank = Feature(name="blank", about="", **hooks)
    assert plug_in(plugged().features.adding(blank)).failures == ()
    program = kinematic(map="square")
    shown = run(program, 1.0)
    right = program.field.extent[2]
    program.engine.commands.put(PlaceCommand(type="place", x=right - 0.1, y=0.0, theta=0.0))
    shown += run(program, 1.0)
    scans = {one.filter.line_scan.scan.stamp: one.filter.line_scan.scan for one in shown
             if one.filter.line_scan is not None}  # fmt: skip
    blanks = sum(not np.isfinite(scan.ranges).any() for scan in scans.values())
    assert 10 < blanks < len(scans)
    (value,) = (value for value in values() if value.name == "blank_pictures")
    assert value.shown(shown[-1]) == blanks


def test_the_command_of_the_document_drives_until_its_programme_ends():
    document = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")
    code: dict[str, Any] = {"__name__": "wave"}
    exec(re.search(r"```python\n(# wave/commands.py.*?)```", document, re.S)[1], code)
    wave = Feature(name="wave", about="", commands=(code["rows"],))
    assert plug_in(plugged().features.adding(wave)).failures == ()
    program = kinematic(map="square")
    command = code["WaveCommand"]
    shown = run(program, 0.02, command(type="wave", start=True))
    while shown[-1].mode == "wave":
        shown += run(program, 0.02, command(type="wave"))
    assert 6.2 < shown[-1].stamp < 6.4
    turned = [snapshot.twist.omega for snapshot in shown]
    assert min(turned) < -0.5 < 0.5 < max(turned)
    assert [snapshot.problems.present for snapshot in shown] == len(shown) * [()]


class StrangersFilter(KalmanFilter):
    """A filter of none of our names; the base's ``of`` makes it."""


def test_a_filter_of_another_package_follows_the_robot():
    kind = FilterKind("mine", f"{__name__}:StrangersFilter.of", has_sensor_model=False)
    assert plug_in(lamps(filters=(lambda: (kind,),))).failures == ()
    chosen = LocalizationParameters(filter=FilterParameters(filter="mine"))
    program = build_program(Config(robot="kinematic", localization=chosen))
    snapshot = run(program, 2.0)[-1]
    program.robot.close()
    assert isinstance(program.engine.controls.localization.localizer.filter, StrangersFilter)
    assert snapshot.truth.distance_to(snapshot.pose) < 0.01


def test_a_filter_that_nobody_offers_is_refused():
    plug_in(Features())
    with pytest.raises(SettingError, match=r"filter is 'grid'; valid are hypotheses, particles"):
        FilterParameters(filter="grid")


class StrangersWorld(MujocoWorld):
    """Forces of none of our names."""


def strangers_robot():
    program = build_program(Config(robot="sim", map="square", sim=SimSettings(engine="mine")))
    snapshot = run(program, 1.0, EIGHT)[-1]
    program.robot.close()
    return program.robot, snapshot


def test_an_engine_of_another_package_moves_the_robot():
    require_engine("mujoco")
    mine = engine("mine", "sim.mujoco_world:load_mujoco")
    assert plug_in(lamps(engines=(lambda: (mine,),))).failures == ()
    robot, snapshot = strangers_robot()
    assert isinstance(robot._world, StrangersWorld)
    assert robot.engine == f"mine {np.__version__}"
    assert snapshot.truth.distance_to(snapshot.pose) < 0.01
    assert snapshot.truth.distance_to(load_field("square", MAPS).start) > 0.02
    # Ours comes first, as it is the same everywhere; another one is chosen by its name.
    plug_in(Features((Feature(name="lamps", about="", engines=(lambda: (mine,),)),)))
    assert (tuple(ENGINES), choose_engine()) == (("mujoco", "mine"), "mujoco")


def test_an_engine_that_cannot_be_loaded_is_not_there_and_says_why():
    require_engine("mujoco")
    broken = Feature(name="lamps", about="", engines=(lambda: (engine("mine", "gone:load"),),))
    assert plug_in(Features((broken,))).failures == ()
    assert choose_engine() == "mujoco"
    with pytest.raises(PackageError, match="engine mine cannot be used: ModuleNotFoundError: No m"):
        strangers_robot()


def test_without_bullet_mujoco_moves_the_robot():
    require_engine("mujoco")
    plug_in(find_features(["bullet"]))
    assert (tuple(ENGINES), choose_engine()) == (("mujoco",), "mujoco")
    for choose in (choose_engine, SimSettings):
        with pytest.raises(SettingError, match=r"engine is 'bullet'; valid are auto, mujoco$"):
            choose("bullet")


class StrangersRobot:
    """Simulated, and none of our classes: what it does is a robot's without forces."""

    def __init__(self, blueprint):
        self.field = blueprint.field
        self._robot = build_kinematic(blueprint)

    def __getattr__(self, name):
        return getattr(self._robot, name)


def test_another_field_builds_a_strangers_simulated_robot_anew_and_keeps_a_real_one():
    made = (
        RobotKind(name="wobble", about="", build=StrangersRobot, is_simulated=True),
        RobotKind(name="real", about="", build=StrangersRobot),
    )
    assert plug_in(lamps(robots=(lambda: made,))).failures == ()
    town = load_field("town", MAPS)
    for name, anew in (("wobble", True), ("real", False)):
        program = build_program(Config(robot=name, map="square"))
        following = build_on_field(program, "town", town)
        assert (following.robot is not program.robot) == anew
        assert (following.robot.field is town) == anew
        assert following.field is town
        following.robot.close()
