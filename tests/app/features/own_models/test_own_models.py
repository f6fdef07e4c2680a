"""A user's own models: made, watched, guarded; through the engine, without waiting."""

from dataclasses import replace

import numpy as np
import pytest
from engine_runs import EIGHT
from own_programs import FLAT, run, undoubted

from app.engine.commands import check
from app.features.own_models import own_models
from app.messages.commands import ResetCommand, ScatterCommand, SetParametersCommand
from app.messages.driving_commands import DriveCommand, StopCommand
from robot.errors import CommandError
from robot.scanning.line_scanner import LineScanner


def test_an_own_sensor_model_weighs_the_particles(save, with_own):
    path = save("""
        class East:
            def log_likelihood(self, poses, scan):
                return 1000 * poses[:, 0]
    """)
    shown = run(with_own(path, "East"), 1.0, EIGHT)
    cloud = shown.filter.cloud
    assert shown.filter.fault is None
    assert np.corrcoef(cloud.poses[:, 0], cloud.weights)[0, 1] > 0.5
    assert shown.filter.models.sensor == "mine.py:East"


def test_an_own_motion_model_moves_them(save, with_own):
    path = save("""
        class Jumps:
            def sample(self, poses, moved, rng):
                return poses + [0.01, 0.0, 0.0]
    """)
    shown = run(with_own(motion=f"{path}:Jumps"), 0.5, EIGHT)
    assert shown.filter.fault is None
    assert shown.filter.cloud.poses[:, 0].mean() > 0.05


def test_a_class_is_given_what_it_asks_for_by_name(save, with_own):
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
    program = with_own(path, "Asks")
    assert run(program, 0.5, EIGHT).filter.fault is None


def test_live_parameters_reach_an_own_model(save, with_own):
    path = save("""
        import numpy as np

        class Strict:
            def __init__(self, parameters):
                self.sigma = parameters.sigma_hit
            def log_likelihood(self, poses, scan):
                assert self.sigma < 0.2, f"sigma is {self.sigma}"
                return np.zeros(len(poses))
    """)
    program = with_own(path, "Strict")
    assert run(program, 0.5, EIGHT).filter.fault is None
    program.engine.commands.put(
        SetParametersCommand(type="set_parameters", values={"sigma_hit": 0.3})
    )
    assert run(program, 0.5, EIGHT).filter.fault == "mine.py line 8: AssertionError: sigma is 0.3"


@pytest.mark.parametrize("text", ["x", "class Mine: pass", "class Mine:\n def sample(self): pass"])
@pytest.mark.parametrize("kind", ["sensor", "motion"])
def test_while_a_model_is_broken_the_robot_stands_and_says_why(save, with_own, kind, text):
    path = save(text)
    program = with_own(path, "Mine") if kind == "sensor" else with_own(motion=f"{path}:Mine")
    shown = run(program, 0.6, EIGHT)
    assert shown.filter.fault.startswith("mine.py")
    assert shown.problems.present == (f"The robot stands still: {shown.filter.fault}",)
    assert shown.filter.updates == 0
    assert shown.mode == "idle"
    assert shown.truth == program.field.start


def test_after_mending_it_goes_on_by_itself(save, with_own):
    program = with_own(save(FLAT))
    before = run(program, 1.0, EIGHT)
    save(FLAT.replace("np.zeros", "np.zerros"))
    broken = run(program, 1.0, EIGHT)
    assert "line 6: AttributeError: module 'numpy' has no attribute 'zerros'" in broken.filter.fault
    assert run(program, 0.5, EIGHT).truth == broken.truth
    assert broken.filter.updates < before.filter.updates + 20
    save(FLAT)
    mended = run(program, 1.0, EIGHT)
    assert mended.filter.fault is None
    assert undoubted(mended) == []
    assert mended.filter.updates > broken.filter.updates + 5
    assert mended.truth.distance_to(broken.truth) > 0.03


def test_standing_still_a_mended_model_is_asked_once(save, with_own):
    program = with_own(save("x"), "Flat")
    assert run(program, 0.5).filter.fault == "mine.py line 1: NameError: name 'x' is not defined"
    save(FLAT)
    assert run(program, 1.0).filter.updates == 1


def test_a_fault_while_driving_stops_the_robot_and_keeps_the_belief(save, with_own):
    program = with_own(save(FLAT))
    run(program, 1.0, EIGHT)
    save(FLAT.replace("return", "assert len(poses) < 3\n            return"))
    broken = run(program, 1.5, EIGHT)
    assert broken.filter.fault == "mine.py line 6: AssertionError"
    assert broken.pose.distance_to(broken.truth) < 0.05
    assert np.isfinite(broken.filter.cloud.poses).all()
    assert broken.filter.cloud.weights.sum() == pytest.approx(1)


def test_while_it_is_broken_driving_is_refused_and_stop_is_not(save, with_own):
    program = with_own(save("x"), "Flat")
    run(program, 0.1)
    for command in (EIGHT, DriveCommand(type="drive", v=0.1, omega=0)):
        with pytest.raises(CommandError, match=r"stands still until .* mine\.py line 1"):
            check(command, program)
    check(StopCommand(type="stop"), program)


def test_while_it_is_broken_the_rest_works(save, with_own):
    program = with_own(save("x"), "Flat")
    program.engine.commands.put(ScatterCommand(type="scatter"))
    shown = run(program, 0.5)
    assert shown.filter.line_scan is not None
    assert np.ptp(shown.filter.cloud.poses[:, 0]) > 0.8
    program.engine.commands.put(
        SetParametersCommand(type="set_parameters", values={"laser_model_type": "beam"})
    )
    assert run(program, 1.0, EIGHT).problems.present == ()
    program.engine.commands.put(ResetCommand(type="reset"))
    assert run(program, 0.1).filter.models.sensor == "mine.py:Flat"


def test_a_model_cannot_change_what_others_see(save, with_own):
    path = save("""
        import numpy as np

        class Writes:
            def log_likelihood(self, poses, scan):
                scan.ranges[:] = 1
                scan.bearings[:] = 1
                scan.sight[:] = np.nan
                poses[:] = 7
                return np.zeros(len(poses))
    """)
    shown = run(with_own(path, "Writes"), 0.5, EIGHT)
    assert shown.filter.fault is None
    assert np.abs(shown.filter.cloud.poses[:, :2]).max() < 1
    seen = shown.filter.line_scan.scan
    assert not (seen.ranges == 1).any()
    # These two are the scanner's own, the same for all scans.
    assert np.ptp(seen.bearings) > 1
    assert np.isfinite(seen.sight).all()


def test_other_parameters_do_not_hide_a_fault(save, with_own):
    program = with_own(save(FLAT.replace("zeros", "zerros")))
    fault = run(program, 0.1).filter.fault
    assert "has no attribute 'zerros'" in fault
    program.engine.commands.put(
        SetParametersCommand(type="set_parameters", values={"sigma_hit": 0.004})
    )
    program.engine.step()
    # Of this very step: the model was asked before the filter was.
    assert program.engine.localization.fault == fault
    assert program.engine.latest.get().filter.updates == 0


def test_chosen_with_other_parameters_it_is_made_once_and_its_fault_stays(save, with_own, tmp_path):
    save("""
        class Broken:
            def __init__(self, parameters):
                with open(__file__ + ".txt", "a") as told:
                    told.write(f"{parameters.sigma_hit} ")
            def log_likelihood(self, poses, scan):
                return missing
    """)
    localization = with_own(folder=tmp_path).engine.localization
    (own,), parameters = localization.added, localization.parameters
    other = replace(parameters, sensor=replace(parameters.sensor, sigma_hit=0.004))
    localization.choose(replace(own.choice, sensor="mine.py:Broken"), other)
    assert localization.fault == "mine.py line 7: NameError: name 'missing' is not defined"
    assert (tmp_path / "mine.py.txt").read_text() == "0.004 "


def test_what_was_in_use_is_put_back_with_its_parameters(save, with_own):
    localization = with_own(save(FLAT)).engine.localization
    (own,), parameters = localization.added, localization.parameters
    other, before = (
        replace(parameters, sensor=replace(parameters.sensor, sigma_hit=0.004)),
        own.in_use,
    )
    own.make(other, fresh=False)
    assert own.in_use != before
    own.put_back(before, parameters)
    own.make(parameters, fresh=False)
    assert own.in_use == before
    own.make(other, fresh=False)
    assert own.in_use != before


def test_a_slow_model_is_told_and_goes_on(save, monkeypatch, with_own):
    monkeypatch.setattr(own_models, "SLOW_S", 0.0)
    shown = run(with_own(save(FLAT)), 0.5, EIGHT)
    assert shown.filter.fault is None
    assert undoubted(shown)[0].startswith("mine.py:Flat takes ")
    assert shown.mode == "figure_eight"


def test_a_model_that_the_filter_does_not_ask_is_told(save, with_own):
    program = with_own(save(FLAT))
    # A camera over bare floor: nothing to weigh.
    program.engine.localization.scanner = LineScanner(
        program.robot.spec.floor_view, replace(program.config.scanner, tape_width=0.2)
    )
    shown = run(program, 3.0, EIGHT)
    assert undoubted(shown) == [
        "mine.py:Flat is not used: no tape is in sight, or this filter needs no sensor model."
    ]
    assert shown.mode == "figure_eight"
