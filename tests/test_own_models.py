"""A user's own models: made, watched, guarded; through the engine, without waiting."""

from dataclasses import replace

import numpy as np
import pytest

from app.assembly import Program, assemble
from app.config import Config
from app.engine.driving import Driving
from app.engine.engine import Engine
from app.engine.localization import Localization
from app.engine.snapshot import Snapshot
from app.messages.commands import (
    DriveCommand,
    FigureEightCommand,
    ResetCommand,
    ScatterCommand,
    SetParametersCommand,
    StopCommand,
)
from app.own_models import own_models
from app.own_models.own_models import OwnChoice, OwnModels
from app.web.commands import CommandError, check
from app.web.telemetry import parameter_messages
from robot.driving.differential_drive import DifferentialDrive
from robot.driving.drive_controller import DriveController
from robot.driving.odometry import Odometry
from sim.simulated import PERIOD

EIGHT = FigureEightCommand(type="figure_eight")
FLAT = """
    import numpy as np

    class Flat:
        def log_likelihood(self, poses, scan):
            return np.zeros(len(poses))
"""
STILL = """
    class Still:
        def sample(self, poses, moved, rng):
            return poses
"""


def run(program: Program, seconds: float, *renewed) -> Snapshot:
    for _ in range(round(seconds / PERIOD)):
        for command in renewed:
            program.engine.commands.put(command)
        shown = program.engine.step()
    return shown


@pytest.fixture(scope="module")
def base():
    return assemble(Config(robot="kinematic"))


@pytest.fixture
def build(base):
    """Makes a program with models of the user's own; robot and field are made only once."""

    def make(path="", name="Flat", motion="", folder=""):
        own = OwnModels(
            base.field, sensor=path and f"{path}:{name}", motion=motion, folder=str(folder)
        )
        kinematics = DifferentialDrive(base.robot.spec)
        base.robot.place(base.field.start)
        base.robot.write(np.zeros(2))
        engine = Engine(
            base.robot,
            Odometry(kinematics, base.config.odometry),
            Localization(
                base.scanner, base.field, base.config.localization, np.random.default_rng(0), own
            ),
            Driving(DriveController(kinematics, base.config.drive), 0.5),
            base.field.start,
        )
        return replace(base, engine=engine, given=own.choice)

    return make


def test_an_own_sensor_model_weighs_the_particles(save, build):
    path = save("""
        class East:
            def log_likelihood(self, poses, scan):
                return 1000 * poses[:, 0]
    """)
    shown = run(build(path, "East"), 1.0, EIGHT)
    cloud = shown.cloud
    assert shown.fault is None
    assert np.corrcoef(cloud.poses[:, 0], cloud.weights)[0, 1] > 0.5
    assert shown.own.sensor == "mine.py:East"


def test_an_own_motion_model_moves_them(save, build):
    path = save("""
        class Jumps:
            def sample(self, poses, moved, rng):
                return poses + [0.01, 0.0, 0.0]
    """)
    shown = run(build(motion=f"{path}:Jumps"), 0.5, EIGHT)
    assert shown.fault is None
    assert shown.cloud.poses[:, 0].mean() > 0.05


def test_a_class_is_given_what_it_asks_for_by_name(save, build):
    path = save("""
        from dataclasses import dataclass
        import numpy as np

        @dataclass
        class Asks:
            edges: object
            parameters: object
            field: object
            more: int = 3

            def log_likelihood(self, poses, scan):
                assert self.edges.shape[1] == 4 and self.field.name == "square"
                return np.full(len(poses), self.parameters.sigma_hit)
    """)
    program = build(path, "Asks")
    assert run(program, 0.5, EIGHT).fault is None


def test_live_parameters_reach_an_own_model(save, build):
    path = save("""
        import numpy as np

        class Strict:
            def __init__(self, parameters):
                self.sigma = parameters.sigma_hit
            def log_likelihood(self, poses, scan):
                assert self.sigma < 0.2, f"sigma is {self.sigma}"
                return np.zeros(len(poses))
    """)
    program = build(path, "Strict")
    assert run(program, 0.5, EIGHT).fault is None
    program.engine.commands.put(
        SetParametersCommand(type="set_parameters", values={"sigma_hit": 0.3})
    )
    assert run(program, 0.5, EIGHT).fault == "mine.py line 8: AssertionError: sigma is 0.3"


@pytest.mark.parametrize("text", ["x", "class Mine: pass", "class Mine:\n def sample(self): pass"])
@pytest.mark.parametrize("kind", ["sensor", "motion"])
def test_while_a_model_is_broken_the_robot_stands_and_says_why(save, build, kind, text):
    path = save(text)
    program = build(path, "Mine") if kind == "sensor" else build(motion=f"{path}:Mine")
    shown = run(program, 0.6, EIGHT)
    assert shown.fault.startswith("mine.py")
    assert shown.problems == (f"The robot stands still: {shown.fault}",)
    assert shown.updates == 0
    assert shown.mode == "idle"
    assert shown.truth == program.field.start


def test_after_mending_it_goes_on_by_itself(save, build):
    program = build(save(FLAT))
    before = run(program, 1.0, EIGHT)
    save(FLAT.replace("np.zeros", "np.zerros"))
    broken = run(program, 1.0, EIGHT)
    assert "line 6: AttributeError: module 'numpy' has no attribute 'zerros'" in broken.fault
    assert run(program, 0.5, EIGHT).truth == broken.truth
    assert broken.updates < before.updates + 20
    save(FLAT)
    mended = run(program, 1.0, EIGHT)
    assert mended.fault is None
    assert mended.problems == ()
    assert mended.updates > broken.updates + 5
    assert mended.truth.distance_to(broken.truth) > 0.03


def test_standing_still_a_mended_model_is_asked_once(save, build):
    program = build(save("x"), "Flat")
    assert run(program, 0.5).fault == "mine.py line 1: NameError: name 'x' is not defined"
    save(FLAT)
    assert run(program, 1.0).updates == 1


def test_a_fault_while_driving_stops_the_robot_and_keeps_the_belief(save, build):
    program = build(save(FLAT))
    run(program, 1.0, EIGHT)
    save(FLAT.replace("return", "assert len(poses) < 3\n            return"))
    broken = run(program, 1.5, EIGHT)
    assert broken.fault == "mine.py line 6: AssertionError"
    assert broken.pose.distance_to(broken.truth) < 0.05
    assert np.isfinite(broken.cloud.poses).all()
    assert broken.cloud.weights.sum() == pytest.approx(1)


def test_while_it_is_broken_driving_is_refused_and_stop_is_not(save, build):
    program = build(save("x"), "Flat")
    run(program, 0.1)
    for command in (EIGHT, DriveCommand(type="drive", v=0.1, omega=0)):
        with pytest.raises(CommandError, match=r"stands still until .* mine\.py line 1"):
            check(command, program)
    check(StopCommand(type="stop"), program)


def test_while_it_is_broken_the_rest_works(save, build):
    program = build(save("x"), "Flat")
    program.engine.commands.put(ScatterCommand(type="scatter"))
    shown = run(program, 0.5)
    assert shown.line_scan is not None
    assert np.ptp(shown.cloud.poses[:, 0]) > 0.8
    program.engine.commands.put(
        SetParametersCommand(type="set_parameters", values={"laser_model_type": "beam"})
    )
    assert run(program, 1.0, EIGHT).problems == ()
    program.engine.commands.put(ResetCommand(type="reset"))
    assert run(program, 0.1).own.sensor == "mine.py:Flat"


def test_a_model_cannot_change_what_others_see(save, build):
    path = save("""
        import numpy as np

        class Writes:
            def log_likelihood(self, poses, scan):
                scan.ranges[:] = 1
                poses[:] = 7
                return np.zeros(len(poses))
    """)
    shown = run(build(path, "Writes"), 0.5, EIGHT)
    assert shown.fault is None
    assert np.abs(shown.cloud.poses[:, :2]).max() < 1
    assert not (shown.line_scan.scan.ranges == 1).any()


def test_a_slow_model_is_told_and_goes_on(save, monkeypatch, build):
    monkeypatch.setattr(own_models, "SLOW_S", 0.0)
    shown = run(build(save(FLAT)), 0.5, EIGHT)
    assert shown.fault is None
    assert shown.problems[0].startswith("mine.py:Flat takes ")
    assert shown.mode == "figure_eight"


# --- a folder --------------------------------------------------------------------------------


def test_models_dropped_into_the_folder_are_offered_and_chosen_live(save, tmp_path, build):
    program = build(folder=tmp_path)
    assert run(program, 0.3).own == OwnChoice()
    save(FLAT)
    save(STILL, "still.py")
    shown = run(program, 0.5)
    assert (shown.own.sensors, shown.own.motions) == (("mine.py:Flat",), ("still.py:Still",))
    values = {"laser_model_type": "mine.py:Flat", "robot_model_type": "still.py:Still"}
    command = SetParametersCommand(type="set_parameters", values=values)
    check(command, program)
    program.engine.commands.put(command)
    shown = run(program, 0.5, EIGHT)
    assert (shown.own.sensor, shown.own.motion) == ("mine.py:Flat", "still.py:Still")
    messages = parameter_messages(shown.parameters, Config().localization, shown.own, program.given)
    sensor = next(one for one in messages if one.name == "laser_model_type")
    assert sensor.value == "mine.py:Flat"
    assert sensor.choices[-1] == "mine.py:Flat"
    assert sensor.default == "likelihood_field"


def test_a_model_in_use_stays_on_offer_when_its_file_goes(save, tmp_path, build):
    path = save(FLAT)
    program = build(path, folder=tmp_path)
    run(program, 0.5, EIGHT)
    path.unlink()
    shown = run(program, 1.0, EIGHT)
    assert shown.fault is None
    assert shown.own.sensors == ("mine.py:Flat",)


def test_a_file_that_is_no_python_is_told_and_stops_nothing(save, tmp_path, build):
    save("def x(:", "other.py")
    shown = run(build(folder=tmp_path), 0.5, EIGHT)
    assert shown.problems == ("other.py line 1: SyntaxError: invalid syntax",)
    assert shown.twist.v > 0


def test_a_model_that_is_not_on_offer_is_refused(save, tmp_path, build):
    save(FLAT)
    program = build(folder=tmp_path)
    run(program, 0.1)
    values = {"laser_model_type": "mine.py:Round"}
    with pytest.raises(CommandError, match=r"on offer: mine\.py:Flat"):
        check(SetParametersCommand(type="set_parameters", values=values), program)


def test_a_model_that_vanished_since_it_was_chosen_stops_nothing(save, tmp_path, build):
    path = save(FLAT)
    program = build(folder=tmp_path)
    run(program, 0.3)
    path.unlink()
    values = {"laser_model_type": "mine.py:Flat"}
    run(program, 0.4)
    program.engine.commands.put(SetParametersCommand(type="set_parameters", values=values))
    shown = program.engine.step()
    assert "A change was not taken" in shown.problems[0]
    assert shown.own.sensor == ""
