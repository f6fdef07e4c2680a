"""The locks hold on each system that people have, with each Python, by a resolver's word."""

import importlib.util

import pytest
from resolved_platforms import LOCKS, PYTHONS, ROOT, SYSTEMS, NoIndexError, kept, resolved


@pytest.mark.parametrize("part", LOCKS)
@pytest.mark.parametrize("system", SYSTEMS)
@pytest.mark.parametrize("python", PYTHONS)
def test_everything_is_installed_from_wheels_that_the_lock_names(part, system, python):
    answer = kept(part)[system, python]
    assert not answer.missing
    locked = (ROOT / LOCKS[part]).read_text(encoding="utf-8")
    for name, version in answer.packages.items():
        assert f"\n{name}=={version} " in locked


def test_each_place_has_physics():
    engines = {place: answer.engine for place, answer in kept("the program").items()}
    assert engines.pop(("Linux x86-64", "3.11")) == "pybullet"
    assert set(engines.values()) == {"MuJoCo"}


@pytest.mark.slow
def test_a_package_without_a_wheel_is_named(tmp_path):
    if importlib.util.find_spec("uv") is None:
        pytest.skip("needs the resolver uv: make test installs it")
    lock = tmp_path / "lgpio.lock"
    lock.write_text("lgpio==0.2.2.0\n")
    try:
        answer = resolved(lock, ("Linux aarch64", "3.14"))
    except NoIndexError as error:
        pytest.skip(f"needs a package index: {error}")
    assert answer.missing == "lgpio"
    assert answer.engine == "none"
