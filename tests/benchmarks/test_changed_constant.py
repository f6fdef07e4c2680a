"""Constants are changed as if the source said so, wherever they stand."""

from __future__ import annotations

import subprocess
import sys

import pytest

from benchmarks.changed_constant import Constant

CHANGED = """
from benchmarks.changed_constant import Constant, change
change([Constant.of(name) for name in {name!r}.split("+")], {value!r})
from {module} import {shown}
print({shown})
"""


def changed(name: str, value: str, shown: str) -> str:
    """In a process of its own: a change holds for as long as a process lives."""
    module = Constant.of(name.partition("+")[0]).module
    code = CHANGED.format(name=name, value=value, module=module, shown=shown)
    return subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    ).stdout.strip()


def test_a_constant_is_doubled() -> None:
    assert changed("claims.MAX_RADIUS", "*2", "MAX_RADIUS") == "2.0"


def test_in_a_row_only_the_named_one_changes() -> None:
    assert changed("monitoring.claims.WAY", "0.07", "TURNED, WAY, TURN") == "0.3 0.07 0.05"


def test_several_of_a_module_change_together() -> None:
    names = "monitoring.claims.WAY+monitoring.claims.MAX_RADIUS+monitoring.claims.TURN"
    assert changed(names, "*2", "TURNED, WAY, TURN, MAX_RADIUS") == "0.3 0.06 0.1 2.0"


def test_what_is_made_of_it_changes_too() -> None:
    as_it_is = float(changed("picture_noise.CONTRAST", "*1", "LIGHT_CONTRAST"))
    half = float(changed("picture_noise.CONTRAST", "*0.5", "LIGHT_CONTRAST"))
    assert as_it_is == pytest.approx(1 / 0.17 - 1) and half == pytest.approx(1 / 0.585 - 1)


def test_a_whole_number_stays_whole_and_above_zero() -> None:
    assert changed("searches.LOST", "*0.1", "LOST") == "1"


def compiled_users(name: str) -> set[str]:
    return {function for _, function in Constant.of(name).compiled_users}


def test_compiled_functions_that_have_a_constant_built_in_are_known() -> None:
    assert compiled_users("scan_residuals.GATE") == {"residual_sums"}
    # Of the module itself, its callers, and a module that imports the constant.
    assert compiled_users("scan_matching.TAIL") >= {"_cauchy", "fit_rays", "add_step"}
    # By a constant that is made of it.
    made = compiled_users("ray_sums.FACING_SHIFT")
    assert compiled_users("entry_planes.DIRECTIONS") >= made > set()


def test_a_constant_that_no_compiled_function_reads_has_none_though_its_module_compiles() -> None:
    assert compiled_users("kidnapping.FRESH") == compiled_users("track.STUCK") == set()


@pytest.mark.parametrize("name", ["BEAMS", "monitor.NOWHERE", "nowhere.TORN"])
def test_an_unknown_name_is_refused(name: str) -> None:
    with pytest.raises(ValueError, match=name):
        Constant.of(name)
