"""Examples in docstrings, run as tests."""

import doctest
import pkgutil
from importlib import import_module

import numpy as np
import pytest
from helpers import ROOT


def modules_with_examples() -> list[str]:
    """Names of all modules of `solver` and `fab` whose source has a prompt, packages included."""
    paths = [str(ROOT / package) for package in ("solver", "fab")]
    names = ["solver", "fab"]
    for path, package in zip(paths, list(names), strict=True):
        names += [module.name for module in pkgutil.walk_packages([path], f"{package}.")]
    return sorted(name for name in names if ">>>" in source_of(name))


def source_of(name: str) -> str:
    """The source of a module; it is not imported, so that `__main__` does not run."""
    path = ROOT.joinpath(*name.split("."))
    file = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    return file.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", modules_with_examples())
def test_examples_in_docstrings_hold(name):
    assert not name.endswith("__main__"), "a module that runs when imported has no examples"
    failed, tried = doctest.testmod(import_module(name), extraglobs={"np": np})
    assert tried > 0
    assert failed == 0


def test_packages_and_modules_with_examples_are_found():
    names = modules_with_examples()
    assert {"solver", "solver.graphs", "fab.errors"} <= set(names)
