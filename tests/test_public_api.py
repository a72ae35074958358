"""Public names: a light import, and one home each, which contributors find."""

import ast
import re
import subprocess
import sys
from importlib import import_module

import pytest
from helpers import ROOT

import fab


def typed_names():
    """Name and module of all that type checkers see in `fab`."""
    tree = ast.parse((ROOT / "fab" / "__init__.py").read_text(encoding="utf-8"))
    (block,) = (node for node in tree.body if isinstance(node, ast.If))
    imports = (node for node in block.body if isinstance(node, ast.ImportFrom))
    return {alias.name: node.module for node in imports for alias in node.names}


def test_names_are_the_same_for_users_and_type_checkers():
    assert typed_names() == fab._MODULES
    assert set(fab.__all__) == {*fab._MODULES, "__version__"}
    assert set(fab.__all__) <= set(dir(fab))


@pytest.mark.parametrize("name", sorted(fab._MODULES))
def test_every_name_is_public_at_home(name):
    home = import_module(fab._MODULES[name])
    assert getattr(fab, name) is getattr(home, name)
    assert name in home.__all__
    assert getattr(fab, name).__doc__


def test_unknown_names_are_refused():
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = fab.nothing


def test_the_import_alone_loads_nothing():
    script = (
        "import sys; before = set(sys.modules); import fab\n"
        "print(sorted({name.partition('.')[0] for name in set(sys.modules) - before}))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    loaded = set(ast.literal_eval(done.stdout))
    assert "fab" in loaded
    assert loaded - {"fab"} <= set(sys.stdlib_module_names)


def test_the_package_names_every_wing():
    text = fab.__doc__.partition("Its wings")[2]
    wings = {path.parent.name for path in (ROOT / "fab").glob("*/__init__.py")}
    assert {line.partition(" :")[0] for line in text.splitlines() if " :" in line} == wings


@pytest.mark.parametrize("package", ["fab"])
def test_packages_are_typed(package):
    assert (ROOT / package / "py.typed").is_file()


def test_places_named_for_contributors_exist():
    text = (ROOT / ".github" / "CONTRIBUTING.md").read_text(encoding="utf-8")
    places = set(re.findall(r"\b((?:fab|solver|tests|templates)/[\w/]+(?:\.\w+)?)", text))
    assert len(places) > 20
    assert {place for place in places if not (ROOT / place).exists()} == set()
