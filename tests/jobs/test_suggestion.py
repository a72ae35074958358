"""Suggestions for patterns that fold further than thick panels of any size can."""

import numpy as np
import pytest
from flat_patterns import fan, grid, pattern_of, triangles
from hypothesis import given, settings
from hypothesis import strategies as st
from shared_cases import shared_case
from thick_sheets import shipped_pattern

from fab import read_pattern
from fab.errors import Severity
from fab.jobs.print_files import make_thick
from fab.jobs.suggestion import suggested_window
from fab.panels.feasibility import Feasibility
from fab.panels.feasible_window import Least, feasible_window
from fab.panels.fold_limit import widest_gap_mm
from fab.panels.inset_limits import rounded_down, rounded_up
from fab.panels.thick_sheet import thicken
from fab.pattern.crease_pattern import scaled
from fab.printing.printability import inspect_print
from fab.printing.thick_settings import thick_settings


def book(width: float, angle: float = 180.0, letter: str = "V"):
    """Two triangles of a square, across its diagonal."""
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * width
    return pattern_of(corners, [[0, 1, 2], [0, 2, 3]], letter, angle=angle)


@given(
    st.floats(10, 500),
    st.sampled_from(["M", "V"]),
    st.sampled_from([["panels.axis=middle"], ["hinges.kind=film"], ["hinges.kind=none"]]),
)
@settings(max_examples=15, deadline=None)
def test_the_limit_is_the_largest_that_works_and_its_numbers_hold(width, letter, changes):
    pattern = book(width, letter=letter)
    tables = thick_settings(changes)
    window = suggested_window(pattern, tables)
    panel, hinge = tables.panels, tables.hinges
    if window.given is None:  # a panel that lies on the side that opens folds flat
        assert window.thickness_max_mm is not None
        return
    assert window.given.panels == 0
    assert window.limit_deg < 180
    here = panel.model_copy(update={"fold_limit_deg": window.limit_deg})
    size = 1.0 if window.panels == 2 else window.scale_min * (1 + 1e-6)
    feasible = Feasibility(book(width * size, letter=letter), here, hinge)
    assert feasible.faces_feasible().all()
    beyond = Feasibility(pattern, here, hinge).largest_limit_deg(
        hinges=True, widest_mm=widest_gap_mm(panel)
    )
    if beyond is not None:
        assert window.limit_deg == pytest.approx(beyond, abs=0.1)
        further = feasible.faces_feasible(limit_deg=beyond + 0.1).all()
        assert not further or not feasible.gaps_kept(beyond + 0.1, widest_gap_mm(panel))
    thinner = here.model_copy(update={"thickness_mm": 0.999 * window.thickness_max_mm})
    assert len(thicken(pattern, thinner, hinge)[0].panels.faces) == 2 or window.panels < 2


@pytest.mark.parametrize(
    "pattern", [book(200.0), fan(6, 100.0), grid(3, 3, 30.0)], ids=["book", "fan", "grid"]
)
def test_folds_that_no_panel_follows_get_useful_numbers(pattern):
    angles = np.where(pattern.edges_foldAngle != 0, np.sign(pattern.edges_foldAngle) * 180.0, 0.0)
    flat = pattern_of(
        pattern.vertices_coords,
        np.split(pattern.faces_vertices, pattern.faces_offsets[1:-1]),
        pattern.edges_assignment,
        angle=np.abs(angles),
    )
    window = suggested_window(flat, thick_settings(["panels.axis=middle"]))
    text = "\n".join(window.lines())
    assert window.given is not None
    assert f"fold_limit_deg = {window.limit_deg:g}, the largest that works" in text
    assert "no size" not in text.split("applies:")[1].replace("no size: panels overlap", "")
    assert window.thickness_max_mm
    assert window.panels == window.faces


def test_a_fold_within_reach_is_suggested_as_before():
    window = suggested_window(book(200.0, 90.0), thick_settings())
    assert window.given is None
    assert window.lines()[0].startswith("2 of 2 faces have a panel")


# What no suggestion leads to.
SPARED = {
    "fold-too-far",
    "fold-limited",
    "hinge-missing",
    "panel-not-convex",
    "panel-side-vanishes",
    "panel-vanishes",
    "panels-loose",
    "wall-too-thin",
}


def suggestions(window, tables):
    """Every suggestion of a window, as changes of the panels and a scale."""
    limit = {"fold_limit_deg": window.limit_deg}
    thickest = window.thickness_max_mm
    if window.clear_max_mm is not None:
        thickest = min(thickest, window.clear_max_mm)
    if thickest:
        yield {**limit, "thickness_mm": float(rounded_down(thickest))}, 1.0
    if window.scale_min is not None:
        yield limit, float(rounded_up(window.scale_min))
    for row in window.rows:
        if row.scale is not None:
            yield {**limit, "thickness_mm": row.thickness_mm}, float(rounded_up(row.scale))


@pytest.mark.parametrize(
    ("name", "width", "changes"),
    [
        ("crane", 150.0, []),
        ("miura", 120.0, ["panels.gap_mm=2.5", "hinges.relief_mm=1.0"]),
        (
            "miura",
            200.0,
            ["hinges.kind=knuckle", "panels.axis=middle", "panels.thickness_mm=4.0"],
        ),
        ("square_twist", 80.0, ["hinges.kind=film"]),
    ],
)
def test_no_suggestion_leads_to_what_it_should_save(name, width, changes):
    pattern = shipped_pattern(name, width)
    tables = thick_settings(changes, "prusa_mk4s", "pp_filament")
    print_with = tables.print_with()
    window = suggested_window(pattern, tables.printed(print_with), printer=print_with.printer)
    every = list(suggestions(window, tables))
    assert len(every) >= 2
    for change, scale in every[:2]:
        given = tables.model_copy(update={"panels": tables.panels.model_copy(update=change)})
        made = make_thick(
            scaled(pattern, factor=scale), name, given, print_with=print_with, formats=["stl"]
        )
        found = {f.code for f in made.findings}
        found -= {f.code for f in made.findings if f.code == "solids-overlap"}
        assert not found & SPARED, (change, scale, found)
        worst = [f.text for f in made.findings if f.code == "solids-overlap"]
        flexed = [f for f in made.findings if f.severity == Severity.WARNING]
        assert not worst or {f.code for f in flexed} >= {"solids-overlap"}, worst


@given(
    st.integers(0, 10_000), st.sampled_from([0.3, 0.8, 2.0]), st.sampled_from(["web", "knuckle"])
)
@settings(max_examples=6, deadline=None)
def test_suggestions_for_random_triangles_have_all_panels_hinges_and_walls(seed, gap, kind):
    pattern = triangles(seed, count=12, size=150.0)
    axis, thick = ("bottom", 1.6) if kind == "web" else ("middle", 4.0)
    changes = [f"hinges.kind={kind}", f"panels.axis={axis}", f"panels.gap_mm={gap}"]
    changes += [f"panels.thickness_mm={thick}", "panels.fold_limit_deg=120.0"]
    tables = thick_settings(changes, "prusa_mk4s", "pp_filament")
    printer = tables.print_with().printer
    tables = tables.printed(tables.print_with())
    least = Least(printer.nozzle_mm, hinges=True)
    window = feasible_window(pattern, tables.panels, tables.hinges, least=least)
    for change, scale in suggestions(window, tables):
        panel = tables.panels.model_copy(update=change)
        sheet, found = thicken(scaled(pattern, factor=scale), panel, tables.hinges)
        joined = sheet.joining.mesh(0)
        codes = {f.code for f in [*found, *inspect_print(sheet, joined, printer)]}
        assert not codes & SPARED, (change, scale, codes)


def test_sides_that_no_size_saves_do_not_set_the_window():
    """A border in line with a crease loses its side to that, however large the comb."""
    pattern, _ = read_pattern(shared_case("comb.fold"))
    window = suggested_window(scaled(pattern, factor=2.0), thick_settings())
    assert window.given is None
    assert window.thickness_max_mm == pytest.approx(40 - 0.5 - 0.05, abs=1e-6)
    assert window.hingeless == 0


@pytest.mark.parametrize("name", ["crane_plain", "unit_square", "cupboard_fold", "keyhole"])
def test_cases_that_fold_by_180_degrees_have_files_without_an_error(name):
    pattern, _ = read_pattern(shared_case(f"{name}.fold"))
    width = np.ptp(pattern.vertices_coords, axis=0).max()
    tables = thick_settings([], "prusa_mk4s", "pp_filament")
    made = make_thick(
        scaled(pattern, factor=200.0 / width),
        name,
        tables,
        print_with=tables.print_with(),
        formats=["stl"],
    )
    assert f"{name}_thick.stl" in made.files
    assert made.within_tolerance
    (limited,) = (f for f in made.findings if f.code == "fold-limited")
    assert f"fold_limit_deg = {made.report['solids']['fold_limit_deg']:g}" in limited.text
    assert len(made.report["solids"]["states"]) >= 2
