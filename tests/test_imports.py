"""The house holds: what each wing may import, no circles, and no heavy library before its time."""

import ast
import subprocess
import sys
from graphlib import TopologicalSorter

import pytest
from helpers import ROOT, TEMPLATES

# What each wing may import besides itself, the solver and the modules at the root of `fab`.
WINGS = {
    "findings": set(),
    "geometry": set(),
    "pattern": {"geometry"},
    "formats": {"geometry", "pattern"},
    "surfaces": {"geometry", "pattern", "formats"},
    "layers": {"geometry", "pattern"},
    "layout": {"geometry", "pattern"},
    "drawings": {"geometry"},
    "sheets": {"geometry", "pattern", "layout", "drawings"},
    "folding": {"geometry", "pattern", "formats"},
    "panels": {"geometry", "pattern"},
    "clearance": {"geometry", "pattern", "formats", "folding", "panels"},
    "printing": {"geometry", "pattern", "formats", "folding", "layout", "panels", "clearance"},
}
WINGS["viewing"] = set(WINGS) - {"surfaces", "sheets"}
WINGS["jobs"] = set(WINGS)
WINGS["studio"] = set(WINGS)
WINGS["sweeps"] = set(WINGS) - {"studio"}
WINGS["cli"] = set(WINGS)
# What each package of the formats may import besides itself and the modules at their root that
# dispatch nothing.
FORMATS: dict[str, set[str]] = {
    "drawn": set(),
    "svg": {"drawn"},
    "dxf": {"drawn"},
    "oripa": {"drawn"},
    "fold": {"drawn"},
    "meshes": {"fold"},
}
# The modules at the root of the formats that know these packages.
DISPATCH = {"reading"}
# The modules at the root of `fab`, each of which imports only those before it.
ROOT_MODULES = [
    *("errors", "files", "interrupts", "scratch", "progress", "settings", "preferences"),
    *("catalogue", "outputs"),
]
# What geometry may know of the solver.
GEOMETRY_TAKES = {
    "solver.errors",
    "solver.graphs",
    "solver.mesh",
    "solver.polygons",
    "solver.vectors",
}
HEAVY = {
    *("build123d", "OCP", "manifold3d", "matplotlib", "reportlab", "trimesh", "u_nesting"),
    "pysat",
    *("starlette", "tomlkit", "uvicorn"),
    *("duckdb", "filelock", "pyarrow", "simpleeval"),
}
SOURCES = {
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
    for package in ("fab", "solver")
    for path in sorted((ROOT / package).rglob("*.py"))
}


def imports_of(source: str) -> set[tuple[str, str]]:
    """Module and name of all that a source takes from `fab` and `solver`."""
    out = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            out |= {(node.module, alias.name) for alias in node.names}
        elif isinstance(node, ast.Import):
            out |= {(alias.name, "") for alias in node.names}
    return {(module, name) for module, name in out if module.split(".")[0] in ("fab", "solver")}


def module_taken(module: str, name: str) -> str:
    """The module that an import is of: `from fab import errors` takes `fab.errors`."""
    inner = f"{module}.{name}"
    return inner if inner in SOURCES else module


def wing_of(module: str) -> str:
    """A wing, or "" for what stands at the root of `fab`."""
    parts = module.split(".")
    return parts[1] if len(parts) > 1 and parts[1] in WINGS else ""


def wrong_among_formats(module: str, taken: str) -> bool:
    """Whether one module of the formats takes another that its package may not know."""
    _, _, own, *inner = module.split(".")
    _, _, other, *rest = taken.split(".")
    if not inner:
        return bool(rest) and own not in DISPATCH
    if not rest:
        return other in DISPATCH
    return other not in FORMATS[own] | {own}


def faults(module: str, source: str) -> list[str]:
    """Every import of a module that its place in the house forbids."""
    out = []
    for taken in sorted({module_taken(*pair) for pair in imports_of(source)}):
        own, other = wing_of(module), wing_of(taken)
        if module.startswith("solver"):
            wrong = taken.startswith("fab")
        elif taken.startswith("solver"):
            wrong = own == "geometry" and taken not in GEOMETRY_TAKES
        elif own:
            wrong = bool(other) and other != own and other not in WINGS[own]
            if own == other == "formats":
                wrong = wrong_among_formats(module, taken)
        else:
            name = module.removeprefix("fab.")
            before = ROOT_MODULES[: ROOT_MODULES.index(name)] if name in ROOT_MODULES else None
            wrong = before is not None and taken.removeprefix("fab.") not in before
        if wrong:
            out.append(f"{module} imports {taken}")
    return out


def test_every_folder_of_fab_is_a_wing():
    folders = {path.name for path in (ROOT / "fab").iterdir() if (path / "__init__.py").is_file()}
    assert folders == set(WINGS)
    modules = {path.stem for path in (ROOT / "fab").glob("*.py")}
    assert modules == {"__init__", "__main__", *ROOT_MODULES}
    formats = ROOT / "fab" / "formats"
    assert {path.parent.name for path in formats.glob("*/__init__.py")} == set(FORMATS)
    assert {path.stem for path in formats.glob("*.py")} >= DISPATCH


@pytest.mark.parametrize("module", sorted(SOURCES))
def test_modules_import_only_what_their_wing_may(module):
    assert faults(module, SOURCES[module].read_text(encoding="utf-8")) == []


def test_forbidden_imports_are_found():
    assert faults("fab.geometry.rings", "from fab.pattern.sectors import x") != []
    assert faults("fab.geometry.rings", "import solver.growth") != []
    assert faults("fab.panels.webs", "def f():\n    from fab import folding") != []
    assert faults("fab.sheets.kerf", "from fab.printing import stl") != []
    assert faults("fab.formats.svg.tree", "from fab.formats.fold.reader import read_fold") != []
    assert faults("fab.formats.drawn.sheet", "from fab.formats import reading") != []
    assert faults("fab.formats.units", "from fab.formats.drawn.lines import Lines") != []
    assert faults("fab.formats.reading", "from fab.formats.drawn.lines import Lines") == []
    assert faults("fab.errors", "from fab.settings import Settings") != []
    assert faults("solver.mesh", "import fab.errors") != []
    assert faults("fab.printing.stl", "from fab.clearance.soundness import parts_of") == []


def test_no_modules_import_each_other():
    graph = {
        module: {module_taken(*pair) for pair in imports_of(path.read_text(encoding="utf-8"))}
        - {module, "fab", "solver"}
        for module, path in SOURCES.items()
        if module not in ("fab", "solver")
    }
    TopologicalSorter(graph).prepare()  # raises CycleError where there is a circle


def test_wings_are_on_a_one_way_path():
    path = {wing: takes - {wing, "jobs", "cli"} for wing, takes in WINGS.items()}
    TopologicalSorter(path).prepare()
    TopologicalSorter(FORMATS).prepare()


# What only some sheets need: the command line names every design; what one of them does comes
# with its first sheet.
LATE = {"shapely", "igl", "rslab", "solver.relaxed_fit", "solver.relaxation"}


@pytest.mark.parametrize(
    ("code", "late", "made"),
    [
        ("import fab.cli.group", HEAVY | LATE, 0),
        ("import solver", HEAVY | LATE, 0),
        (
            "import sys\n"
            "from fab.cli.group import main\n"
            f"sys.argv = ['quadfold', 'run', {str(TEMPLATES / 'curved_fold.toml')!r}, "
            "'--only', 'dxf,fold,svg', '--out', '.']\n"
            "try: main()\n"
            "except SystemExit as stop: assert stop.code == 0, stop.code",
            HEAVY,
            4,
        ),
    ],
    ids=["command line", "solver", "laser path"],
)
def test_libraries_are_loaded_only_where_they_are_used(code, late, made, tmp_path):
    script = f"{code}\nimport sys\nprint(sorted({late} & set(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, cwd=tmp_path
    )
    assert done.stdout.splitlines()[-1] == "[]"
    assert len(list(tmp_path.iterdir())) == made
