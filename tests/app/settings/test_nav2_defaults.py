"""What docs/models.md says of nav2_amcl's defaults, beside ours."""

import re

from app.settings.config import ROOT, Config
from robot.settings import describe

NAV2 = {
    "alpha1": 0.2,
    "alpha2": 0.2,
    "alpha3": 0.2,
    "alpha4": 0.2,
    "alpha5": 0.2,
    "beam_skip_distance": 0.5,
    "beam_skip_error_threshold": 0.9,
    "beam_skip_threshold": 0.3,
    "do_beamskip": False,
    "lambda_short": 0.1,
    "laser_likelihood_max_dist": 2.0,
    "laser_max_range": 100.0,
    "laser_min_range": -1.0,
    "laser_model_type": "likelihood_field",
    "max_beams": 60,
    "max_particles": 2000,
    "min_particles": 500,
    "pf_err": 0.05,
    "pf_z": 0.99,
    "recovery_alpha_fast": 0.0,
    "recovery_alpha_slow": 0.0,
    "resample_interval": 1,
    "save_pose_rate": 0.5,
    "set_initial_pose": False,
    "sigma_hit": 0.2,
    "update_min_a": 0.2,
    "update_min_d": 0.25,
    "z_hit": 0.5,
    "z_max": 0.05,
    "z_rand": 0.5,
    "z_short": 0.05,
}
"""As its node declares them (navigation2 at a3a9704, nav2_amcl/src/amcl_node.cpp)."""


def ours():
    config = Config()
    groups = (
        config.localization.motion,
        config.localization.sensor,
        config.localization.filter,
        config.start_pose,
    )
    return {name: getattr(group, name) for group in groups for name in describe(group)}


def test_all_defaults_that_differ_from_nav2s_are_told():
    page = (ROOT / "docs" / "models.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `(\w+)` \| (-?[\d.]+) \| (-?[\d.]+) \| \S.* \|$", page, re.MULTILINE)
    told = {name: (float(theirs), float(here)) for name, theirs, here in rows}
    here = ours()
    assert told == {name: (was, here[name]) for name, was in NAV2.items() if here[name] != was}
    assert "selective_resampling" in page
