"""Deprecations are errors where our own code causes them, and not within other libraries."""

import warnings

import pytest


@pytest.mark.parametrize("category", [DeprecationWarning, PendingDeprecationWarning])
@pytest.mark.parametrize("module", ["fab", "fab.sheets.kerf", "solver.mesh", __name__])
def test_deprecations_of_our_own_are_errors(module, category):
    with pytest.raises(category):
        warnings.warn_explicit("old", category, "file.py", 1, module)


@pytest.mark.parametrize("module", ["matplotlib._mathtext", "pyparsing.util", "fabric", "ezdxf"])
def test_deprecations_within_libraries_are_shown_alone(module):
    with warnings.catch_warnings(record=True) as shown:
        warnings.warn_explicit("old", DeprecationWarning, "file.py", 1, module)
    assert [str(each.message) for each in shown] == ["old"]


@pytest.mark.parametrize("category", [RuntimeWarning, ResourceWarning, UserWarning])
def test_other_warnings_are_errors_wherever_they_come_from(category):
    with pytest.raises(category):
        warnings.warn_explicit("wrong", category, "file.py", 1, "scipy.sparse")
