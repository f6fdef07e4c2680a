"""Conditions are named settings, and what the simulator does about the new ones."""

import re
from dataclasses import replace

import numpy as np
import pytest
from floor_looks import grey_at

from app.command_line import main, parse
from app.features.lab.evaluation.experiment import WORLDS, in_world
from app.features.lab.sweep.points import points_of
from app.features.lab.sweep.sweep_file import load_sweep
from app.options import config_from
from app.settings.conditions import CONDITIONS, apply_condition
from app.settings.config import MAPS, Config
from robot.description.spec import RobotSpec
from robot.fields.field_loading import load_field
from robot.geometry import Pose2, Twist2
from robot.settings import SettingError
from sim.clutter import add_glare
from sim.exposures import GAP_EVERY, Exposures
from sim.floor_camera import CameraSettings, FloorCamera
from sim.imperfections import Imperfections, draw
from sim.simulated import SimSettings

NAMES = [
    *("default", "noisy", "dark", "uneven", "cluttered", "fast", "askew", "late", "worn"),
    *("slippery", "stretched", "sparse", "gaps", "all-at-once"),
    *("bumped-roll", "bumped-pitch", "bumped-yaw", "as-real", "hand-built"),
]


def test_all_conditions_are_there_and_each_but_the_default_changes_something():
    assert list(CONDITIONS) == NAMES
    for name in NAMES:
        assert (apply_condition(Config(), name) == Config()) == (name == "default")


def test_a_condition_does_not_make_better_what_is_worse_already():
    bad = replace(
        Config(),
        sim=SimSettings(
            camera=CameraSettings(noise=50, light=0.1, frame_rate=2, clutter="shoes"),
            imperfections=Imperfections(slip_sd=0.3),
        ),
    )
    for name in NAMES:
        camera = apply_condition(bad, name).sim.camera
        assert (camera.noise, camera.light, camera.frame_rate) == (50, 0.1, 2)
        assert camera.clutter == "shoes"
        assert apply_condition(bad, name).sim.imperfections.slip_sd == 0.3


def test_an_unknown_condition_lists_the_known_ones():
    with pytest.raises(SettingError, match=re.escape(", ".join(NAMES))):
        apply_condition(Config(), "wet")


def test_worlds_are_conditions_of_a_kind_of_robot():
    for name, (robot, condition) in WORLDS.items():
        config = in_world(Config(), name)
        assert config == replace(apply_condition(Config(), condition), robot=robot)


def test_run_takes_a_condition():
    parsed = parse(["run", "--condition", "askew", "--robot", "sim"])
    assert config_from(parsed).sim.imperfections.camera_angle_sd == 0.5


def test_a_real_robot_has_the_conditions_that_it_has(capsys):
    assert main(["run", "--condition", "askew", "--robot", "buildhat"]) == 2
    assert "--condition has no effect with --robot buildhat" in capsys.readouterr().err


def test_without_faults_there_is_no_condition(capsys):
    with pytest.raises(SystemExit):
        parse(["run", "--without", "faults", "--condition", "askew"])
    assert "--condition" in capsys.readouterr().err


def test_a_sweep_file_names_conditions(tmp_path):
    path = tmp_path / "worse.toml"
    path.write_text(
        '[sweep]\nseeds = 1\nconditions = ["default", "noisy"]\n'
        "[settings]\nsim.camera.noise = [3.0]\n"
    )
    points = points_of(load_sweep(path), Config())
    assert [point.condition for point in points] == ["default", "noisy"]
    # What is swept wins.
    assert [point.config.sim.camera.noise for point in points if point.config] == [3.0, 3.0]


# --- what the simulator does ---


def shares_lost(settings, seconds=600.0, seed=0):
    exposures = Exposures(settings, 0.0, np.random.default_rng(seed))
    stamps = [exposures.newest(time) for time in np.arange(0, seconds, 1 / settings.frame_rate)]
    return np.array([stamp is None for stamp in stamps])


def test_nothing_is_lost_by_default():
    assert not shares_lost(CameraSettings(delay=0, exposure=0), 20).any()


@pytest.mark.parametrize(("share", "burst"), [(0.9, 0.33), (0.3, 0.5), (0.2, 0.0)])
def test_pictures_are_lost_in_bursts_of_a_mean_length(share, burst):
    lost = shares_lost(CameraSettings(lost_share=share, lost_burst=burst))
    assert lost.mean() == pytest.approx(share, abs=0.03)
    bursts = np.count_nonzero(np.diff(lost.astype(int)) == 1)
    assert lost.sum() / bursts / 30 == pytest.approx(max(burst, 1 / 30), rel=0.15)


def test_each_stretch_of_time_has_one_gap():
    lost = shares_lost(CameraSettings(gap=4.0), 10 * GAP_EVERY)
    assert lost.mean() == pytest.approx(4 / GAP_EVERY, abs=0.01)
    for stretch in np.split(lost, 10):
        assert np.count_nonzero(np.diff(stretch.astype(int)) == 1) <= 1


def picture(**settings):
    camera = FloorCamera(
        RobotSpec.load().floor_view,
        load_field("square", MAPS).floor,
        CameraSettings(**{"noise": 0.0, "vignetting": 0.0} | settings),
        np.random.default_rng(0),
    )
    return camera.picture(Pose2(0.1, 0.1, 0.3), Twist2()).astype(float)


def test_less_light_is_a_darker_picture_and_noise_stays():
    bright, dark = picture(), picture(light=0.3)
    np.testing.assert_allclose(dark, 0.3 * bright, atol=1)
    noise = picture(noise=10, light=0.3) - dark
    assert noise.std() == pytest.approx(10, rel=0.1)


def test_glare_only_brightens_and_somewhere_much():
    lit = np.concatenate([(picture(glare=100) - picture()).ravel()])
    assert lit.min() >= -1
    floor = load_field("square", MAPS).floor
    shining = add_glare(floor, 100, np.random.default_rng(0))
    added = shining.image.astype(int) - floor.image
    assert added.min() == 0
    assert 20 < added.max() <= 200
    assert 0.01 < (added > 10).mean() < 0.2


@pytest.mark.slow
def test_a_lens_of_another_focal_length_changes_nothing_else():
    spec, rng = RobotSpec.load(), np.random.default_rng
    true = draw(spec, Imperfections(focal_length_sd=0.02), rng(1))
    plain = draw(spec, Imperfections(), rng(1))
    assert true.joints == plain.joints
    longer = true.lens.matrix[[0, 1], [0, 1]] / spec.lens.matrix[[0, 1], [0, 1]]
    assert longer[0] == pytest.approx(longer[1])
    assert 0 < abs(longer[0] - 1) <= 0.06
    np.testing.assert_array_equal(true.lens.matrix[:2, 2], spec.lens.matrix[:2, 2])
    drawn = [
        draw(spec, Imperfections(focal_length_sd=0.02), rng(seed)).lens.matrix[0, 0]
        for seed in range(60)
    ]
    assert np.std(drawn) / spec.lens.matrix[0, 0] == pytest.approx(0.02, rel=0.3)
    both = Imperfections(focal_length_sd=0.02, camera_angle_sd=0.5)
    askew = draw(spec, replace(both, focal_length_sd=0.0), rng(1))
    np.testing.assert_array_equal(
        draw(spec, both, rng(1)).robot_from_camera, askew.robot_from_camera
    )


def test_a_floor_that_is_larger_than_its_drawing_is_seen_farther_off():
    floor = load_field("square", MAPS).floor
    larger = floor.scaled(1.02)
    points = np.random.default_rng(0).uniform(-0.7, 0.7, (500, 2))
    np.testing.assert_array_equal(grey_at(larger, 1.02 * points), grey_at(floor, points))
    assert np.abs(picture(floor_scale=1.02) - picture()).max() > 50
