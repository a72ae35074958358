"""Pages of the Python packages and of the mathematics, from docstrings."""

from __future__ import annotations

import importlib
import inspect
import re
from types import ModuleType
from typing import Any

from fab.settings import Settings
from made_pages.markdown import anchor, cell, docstring

__all__ = ["mathematics_page", "names_page"]

_ABOUT = {
    "fab": "What `fab` offers: millimetres, machines and files. Examples are in "
    "[the guide](../guide/python.md).",
    "solver": "What `solver` offers: geometry in any unit, angles in radians. Examples are in "
    "[the guide](../guide/python.md), the mathematics on [a page of its own](mathematics.md).",
}
# Chapters of the mathematics, and the modules whose docstrings they are.
_CHAPTERS = {
    "One vertex": ("vertex", "vertex_family"),
    "A strip: one flap angle decides all folds": ("transfer", "front", "rays", "strip_family"),
    "Growth": ("growth", "seeds", "strip_choices", "ending_rows", "growth_order"),
    "Closed rings": ("transfer.loop_closings", "transfer.Closings"),
    "Corners": ("corner",),
    "Costs of a flap angle": ("flap_landscape", "flap_costs", "mirroring"),
    "Faces that cross": ("self_intersection", "arcs"),
    "Following a surface by growth": ("following", "fitting", "targets.base"),
    "Following a surface by relaxation": (
        "relaxation",
        "relaxation.method",
        "relaxation.constraints",
        "relaxation.objectives",
        "relaxation.minimisation",
        "surface_maps",
        "surface_cuts",
    ),
    "Sheets that fold rigidly and flat": ("rigid_march", "flat_foldable"),
    "How exact a sheet is": ("measure",),
}


def names_page(package: str) -> str:
    """All public names of a package: signatures and docstrings."""
    module = importlib.import_module(package)
    out = [f"# Python: {package}\n", _ABOUT[package] + "\n"]
    names = sorted(module.__all__, key=lambda name: (not name[0].isupper(), name.casefold()))
    for name in names:
        thing = getattr(module, name)
        if name == "__version__" or isinstance(thing, ModuleType):
            continue
        out += _entry(package, name, thing)
    return "\n".join(out)


def mathematics_page() -> str:
    """What the docstrings of the solver say of its mathematics, in the order of the paper."""
    out = [
        "# The mathematics\n",
        "What the solver computes, and where in the paper it is: section and equation numbers "
        "are of "
        "the supplementary information of L. H. Dudte, G. P. T. Choi and L. Mahadevan, *An "
        "additive "
        "algorithm for origami design*, PNAS 118 (2021). The text is that of the code's own "
        "docstrings. Angles are in radians.\n",
    ]
    for chapter, names in _CHAPTERS.items():
        out.append(f"## {chapter}\n")
        for name in names:
            module, _, inner = name.partition(".")
            thing = importlib.import_module(f"solver.{module}")
            if (
                inner
                and hasattr(thing, inner)
                and not isinstance(getattr(thing, inner), ModuleType)
            ):
                out += [f"### {inner}\n", _text(getattr(thing, inner)) + "\n"]
                continue
            thing = importlib.import_module(f"solver.{name}")
            out += [f"### solver.{name}\n", _text(thing) + "\n"]
            out += _with_formulas(thing)
    return "\n".join(out)


def _with_formulas(module: ModuleType) -> list[str]:
    """The public functions and classes of a module whose docstrings say how they compute."""
    out = []
    for name in getattr(module, "__all__", []):
        thing = getattr(module, name)
        if getattr(thing, "__module__", "") != module.__name__ or not callable(thing):
            continue
        text = inspect.getdoc(thing) or ""
        if re.search(r"\bS\d|\n\n    \S|Moebius|quadratic|Newton|Kawasaki", text):
            out += [f"#### {name}\n", docstring(text) + "\n"]
    return out


def _entry(package: str, name: str, thing: Any) -> list[str]:
    out = [anchor(f"{package}-{name}") + f"## {name}\n"]
    signature = _signature(name, thing)
    if _is_table(thing):
        out.append("A table of keys: [of a job](job_keys.md).\n")
    elif signature:
        out.append(f"```python\n{signature}\n```\n")
    out.append(_text(thing) + "\n")
    if inspect.isclass(thing):
        out += [
            f"- `{each}{_parameters(member)}`: {cell(_first_line(member))}"
            for each, member in vars(thing).items()
            if not each.startswith("_") and _first_line(member)
        ]
        out.append("")
    return out


def _is_table(thing: Any) -> bool:
    return inspect.isclass(thing) and issubclass(thing, Settings)


def _signature(name: str, thing: Any) -> str:
    if not callable(thing):
        return ""
    try:
        parameters = str(inspect.signature(thing))
    except (TypeError, ValueError):
        return ""
    parameters = parameters.removesuffix(" -> None") if inspect.isclass(thing) else parameters
    shown = re.sub(r"<(\w+)\.(\w+): [^>]*>", r"\1.\2", f"{name}{parameters}".replace("'", ""))
    shown = re.sub(r"<(?:function|class) ([\w.]+)(?: at 0x\w+)?>", r"\1", shown)
    if len(shown) <= 88 or "(" not in shown:
        return shown
    inside, _, after = shown.partition("(")[2].rpartition(")")
    parts = _split(inside)
    return f"{name}(\n" + "".join(f"    {part},\n" for part in parts) + f"){after}"


def _split(text: str) -> list[str]:
    """Parameters between the commas that are in no brackets."""
    parts, depth = [""], 0
    for letter in text:
        depth += (letter in "([{") - (letter in ")]}")
        if letter == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return [part.strip() for part in parts if part.strip()]


def _parameters(member: Any) -> str:
    function = getattr(member, "__func__", member)
    if not inspect.isfunction(function):
        return ""
    names = [name for name in inspect.signature(function).parameters if name not in ("self", "cls")]
    return f"({', '.join(names)})"


def _first_line(member: Any) -> str:
    if not (
        inspect.isfunction(member) or isinstance(member, property | classmethod | staticmethod)
    ):
        return ""
    return (inspect.getdoc(member) or "").partition("\n\n")[0].partition("\n")[0]


def _text(thing: Any) -> str:
    return docstring(inspect.getdoc(thing) or "")
