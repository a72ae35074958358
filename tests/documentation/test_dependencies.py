"""Versions of libraries: the lists of CI are those of pyproject.toml, and licences are listed."""

import re
import tomllib
from importlib import metadata

import pytest
from helpers import DOCS, ROOT
from packaging.markers import Marker
from packaging.requirements import Requirement
from packaging.version import Version

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
DIRECT = [
    Requirement(text)
    for part in (PROJECT["dependencies"], *PROJECT["optional-dependencies"].values())
    for text in part
]
LISTS = ("lock", "oldest")
# What is GPL, LGPL, MPL or the like by its metadata, and what holds parts that are.
COPYLEFT = re.compile(r"GPL|MPL|EPL|CDDL|Mozilla", re.I)
HOLDS = {"cadquery-ocp-novtk", "shapely", "imageio-ffmpeg", "libigl"}


def plain(name):
    return re.sub(r"[-_.]+", "-", name).lower()


def listed(name):
    """Versions of each package, with the marker where each counts."""
    out = {}
    for line in (ROOT / ".ci" / f"{name}.txt").read_text().splitlines():
        if not line.startswith("#"):
            pin, _, marker = line.partition(" ; ")
            package, version = pin.split("==")
            out.setdefault(plain(package), []).append((Version(version), marker))
    return out


@pytest.fixture(scope="module")
def licences():
    table = re.findall(r"^\| `([^`]+)` \| ([^|]+) \| ([^|]+) \|$", page(), re.M)
    return {name: licence for name, licence, _ in table}


def page():
    return (DOCS / "licences.md").read_text()


@pytest.mark.parametrize("name", LISTS)
def test_every_dependency_is_listed_at_a_version_that_is_allowed(name):
    found = listed(name)
    for each in DIRECT:
        versions = [version for version, _ in found[plain(each.name)]]
        assert versions, each
        assert all(each.specifier.contains(version, prereleases=True) for version in versions)


@pytest.mark.parametrize("name", LISTS)
def test_lists_have_no_path_of_a_machine_and_one_version_for_each(name):
    text = (ROOT / ".ci" / f"{name}.txt").read_text()
    assert not re.search(r"file:|://|/home|/tmp|/opt", text)
    for package, versions in listed(name).items():
        markers = [marker for _, marker in versions]
        assert len(versions) == 1 or all(markers), package
        for python in ("3.11", "3.12", "3.13"):
            here = {"python_version": python, "python_full_version": f"{python}.7"}
            counts = sum(not marker or Marker(marker).evaluate(here) for marker in markers)
            assert counts <= 1, package


def test_the_oldest_versions_are_the_lower_bounds():
    """A library that another one wants in a later version has that version as its bound."""
    found = listed("oldest")
    for each in DIRECT:
        bounds = [Version(part.version) for part in each.specifier if part.operator == ">="]
        assert len(bounds) == 1, each
        oldest = min(version for version, _ in found[plain(each.name)])
        assert oldest == bounds[0], each


def test_every_dependency_has_its_licence_on_the_page(licences):
    assert sorted(licences) == sorted(listed("lock"))
    assert all(licences.values())


def test_copyleft_is_mentioned(licences):
    _, _, rest = page().partition("## Copyleft")
    mentioned = rest.partition("## All packages")[0]
    for name in HOLDS | {name for name, its in licences.items() if COPYLEFT.search(its)}:
        assert f"`{name}`" in mentioned, name


def test_licences_are_those_that_installed_packages_state(licences):
    """Of those with an expression of the standard for it; others were read."""
    compared = 0
    for name, licence in licences.items():
        try:
            found = metadata.metadata(name)
        except metadata.PackageNotFoundError:
            continue
        if (
            found.get("License-Expression")
            and (Version(found["Version"]), "") in listed("lock")[name]
        ):
            assert licence == found["License-Expression"], name
            compared += 1
    locked = {name: versions[0][0] for name, versions in listed("lock").items()}
    if Version(metadata.version("numpy")) == locked["numpy"]:
        assert compared > 30


def test_python_versions_are_those_that_are_tested():
    stated = [text for text in PROJECT["classifiers"] if re.search(r":: 3\.\d+$", text)]
    assert [text.rpartition(" ")[2] for text in stated] == ["3.11", "3.12", "3.13"]
    assert PROJECT["requires-python"] == ">=3.11"
