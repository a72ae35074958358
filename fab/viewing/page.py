"""The result page: one HTML file that shows what a command made, and needs nothing else.

It opens without a network: script, styles, pictures and data are within it, and its content
security policy forbids all loading. Without a script, or without WebGL, it shows pictures, drawings
and numbers.
"""

from __future__ import annotations

import base64
import hashlib
import io
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from importlib.resources import files
from typing import Any
from urllib.parse import quote

from fab import __version__
from fab.drawings.cut_paths import CutPaths
from fab.drawings.layer_colours import Colours
from fab.errors import Finding, Severity, counted
from fab.viewing.drawing import CREASE_INK
from fab.viewing.face_triangles import face_corner_triangles
from fab.viewing.html_file import Script, html_file
from fab.viewing.leaflet import Leaflet
from fab.viewing.leaflet_html import leaflet_html
from fab.viewing.level_of_detail import detail_note
from fab.viewing.page_data import has_face_values, page_data, state_names
from fab.viewing.page_drawings import (
    LOWER,
    MOST_LINES,
    UPPER,
    Drawing,
    crease_drawing,
    form_svg,
    shades_css,
    sheet_drawing,
)
from fab.viewing.page_tables import mapping_table, rows_table
from fab.viewing.scene import Scene
from fab.viewing.view_choice import best_view
from solver.vectors import FloatArray

__all__ = ["ResultPage", "page_bytes"]

# Sections of numbers: their title, and the keys of reports that they take, where there are any.
# Short ones first, which are side by side.
_SHORT: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("Accuracy", ("planarity_max", "developability_max_rad", "isometry_max_rel", "crossings")),
    ("Size", ("bounding_box_mm", "counts", "alike_panels")),
    ("Growth", ("growth",)),
)
_LONG: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("Cutting", ("copies", "minutes", "patterns", "sheets")),
    ("Assembly order", ("pieces", "glue_up", "seams")),
    ("Solids", ("solids",)),
    ("Plates", ("plates",)),
    ("Folding", ("verdict", "simulation", "rigid", "layers", "tolerance_deg")),
    ("Under load", ("loads",)),
)
# What is asked for, shown as it is.
_ASKED = ("job", "settings", "material", "hinge_material", "machine", "printer", "solver")
# Of a report, what the page shows elsewhere or, as the seconds, not at all.
_ELSEWHERE = ("outputs", "findings", "seconds", "quadfold", "name")
_PICTURE_COLOURS = 64
# From the least to the largest value.
_RAMP = ("#ffffcc", "#ffeda0", "#fed976", "#feb24c", "#fd8d3c", "#fc4e2a", "#e31a1c", "#800026")


@dataclass(frozen=True)
class ResultPage:
    """What a page shows.

    Attributes
    ----------
    title : the name of the sheet; made_by : the command, such as "quadfold run".
    scene : the sheet and its bodies, in all states.
    report : of the command, as JSON values, without its files and findings.
    findings : with creases and panels by their numbers in the scene's pattern.
    files : made beside the page, by name.
    sheets : drawings that a machine cuts, by title; colours : of their operations.
    pictures : what the pictures among these files show, by name; others are left out.
    assembly : how it is put together.
    panels_state : number of the state in which panels stop; the last one where left out.
    """

    title: str
    made_by: str
    scene: Scene
    report: Mapping[str, Any]
    findings: Sequence[Finding] = ()
    files: Mapping[str, bytes] = field(default_factory=dict)
    sheets: Mapping[str, CutPaths] = field(default_factory=dict)
    colours: Colours | None = None
    pictures: Mapping[str, str] = field(default_factory=dict)
    assembly: Leaflet | None = None
    panels_state: int | None = None


def page_bytes(page: ResultPage) -> bytes:
    """The page as an HTML file, the same bytes for the same page: without dates and durations."""
    axes = _view(page.scene)
    body = [
        *_head(page),
        "<main>",
        *_findings(page),
        *_form(page, axes),
        *_drawings(page),
        *_assembly(page),
        *_numbers(page),
        *_files(page),
        *_asked(page),
        "</main>",
        *_foot(),
    ]
    return html_file(
        f"{page.title}: {page.made_by}",
        _asset("page.css") + shades_css(),
        body,
        _data(page, axes),
        [Script(_asset("views.js")), Script(_asset("page.js"), module=True)],
    )


def _view(scene: Scene) -> FloatArray:
    """Axes of the view that shows most of the last state."""
    triangles, faces = face_corner_triangles(scene.pattern)
    corners = scene.states_coords[-1][scene.pattern.faces_vertices[triangles]]
    return best_view([corners], faces, upright=scene.upright)


def _data(page: ResultPage, axes: FloatArray) -> dict[str, Any]:
    colours = {"upper": UPPER, "lower": LOWER, "edges": CREASE_INK, "ramp": _RAMP}
    data = page_data(page.scene, page.findings)
    last = page.scene.state_count - 1 if page.panels_state is None else page.panels_state
    return {**data, "panelsState": last, "view": axes[2].tolist(), "colours": colours}


def _head(page: ResultPage) -> Iterator[str]:
    yield f"<header><h1>{escape(page.title)}</h1>"
    yield f"<p>made by <code>{escape(page.made_by)}</code></p>"
    yield '<button type="button" id="theme" hidden>Dark</button>'
    yield "</header>"


def _findings(page: ResultPage) -> Iterator[str]:
    by_severity = {
        severity: [f for f in page.findings if f.severity == severity] for severity in Severity
    }
    errors = len(by_severity[Severity.ERROR])
    yield '<section aria-labelledby="findings"><h2 id="findings">Findings</h2>'
    if errors:
        yield (
            f'<p class="verdict error">{counted(errors, "error")}: do not put material under it '
            "as it is.</p>"
        )
    else:
        more = ", ".join(
            counted(len(by_severity[kind]), kind.value)
            for kind in (Severity.WARNING, Severity.NOTE)
            if by_severity[kind]
        )
        yield f'<p class="verdict">Made, and within tolerance{": " + more if more else ""}.</p>'
    if page.findings:
        yield '<ul class="findings">'
        for number, finding in enumerate(page.findings):
            kind = finding.severity.value
            yield (
                f'<li><span class="severity {kind}">{kind}</span> '
                f"<code>{escape(finding.code)}</code> {escape(finding.text)}"
            )
            if finding.creases or finding.panels:
                yield (
                    f' <button type="button" data-finding="{number}" aria-pressed="false" hidden>'
                    f'Show <span class="code">{escape(finding.code)}</span></button>'
                )
            yield "</li>"
        yield "</ul>"
    yield "</section>"


def _form(page: ResultPage, axes: FloatArray) -> Iterator[str]:
    """The form that folds, and the pictures that stand in for it."""
    title = escape(page.title)
    last = page.scene.state_count - 1
    heading = "Folded form" if last else "Sheet, whose folded form is not known"
    yield f'<section id="form" aria-labelledby="form-title"><h2 id="form-title">{heading}</h2>'
    yield '<p class="without" hidden>This browser has no WebGL: pictures take the place of the '
    yield "form that folds.</p>"
    yield '<div class="live-view" hidden><div class="space">'
    yield (
        f'<canvas tabindex="0" role="application" aria-label="{title} in space" '
        'aria-describedby="form-keys"></canvas></div>'
    )
    yield f'<div class="tools"><div class="fold"{"" if last else " hidden"}>'
    yield '<button type="button" id="play" class="main">Fold</button>'
    yield (
        f'<input type="range" id="fold" min="0" max="{last}" step="0.01" value="{last}" '
        'aria-label="Flat to folded">'
    )
    yield f'<output id="state" for="fold">{escape(state_names(page.scene)[-1])}</output></div>'
    if page.scene.bodies is not None:
        yield (
            "<fieldset><legend>Show</legend>"
            '<label><input type="radio" name="shown" value="sheet" checked>sheet</label>'
            '<label><input type="radio" name="shown" value="panels">panels</label></fieldset>'
        )
    yield from _coloured(page.scene)
    note = detail_note(page.scene.pattern.face_count)
    checked = "" if note else " checked"
    yield f'<label><input type="checkbox" id="creases"{checked}>lines</label>'
    yield _steps(("left", "Turn left", "↺"), ("right", "Turn right", "↻"))
    yield "</div>"
    yield '<p class="hint" id="form-keys">Drag, or use the arrow keys, to turn; + and - zoom, and '
    yield f"so does the wheel once the view is chosen; 0 shows the whole. {note}</p></div>"
    yield '<details class="still" open><summary>Pictures</summary><div>'
    pictures = {
        page.pictures[name]: page.files[name] for name in page.pictures if name in page.files
    }
    for shows, picture in pictures.items():
        data = base64.b64encode(_smaller(picture)).decode()
        yield (
            f'<figure><img src="data:image/png;base64,{data}" alt="{title}: {escape(shows)}">'
            f"<figcaption>{escape(shows)}</figcaption></figure>"
        )
    if not pictures:
        yield f"<figure>{form_svg(page.scene, axes, f'{page.title}, folded')}</figure>"
    yield "</div></details></section>"


def _coloured(scene: Scene) -> Iterator[str]:
    """The choice between the colours of the sides and those of values of faces, and their scale."""
    if scene.values is None or not has_face_values(scene) or scene.bodies is not None:
        return
    scale = scene.values.scale
    low, middle, high = (f"{scale.value_at(share):.3g} {scale.unit}" for share in (0, 0.5, 1))
    stops = "".join(
        f'<rect x="{number}" width="1.05" height="1" fill="{colour}"/>'
        for number, colour in enumerate(_RAMP)
    )
    yield (
        "<fieldset><legend>Colour</legend>"
        '<label><input type="radio" name="coloured" value="sides" checked>sides</label>'
        f'<label><input type="radio" name="coloured" value="values">{escape(scale.name)}</label>'
        f'</fieldset><span class="scale" hidden>{escape(low)} '
        f'<svg width="120" height="12" viewBox="0 0 {len(_RAMP)} 1" preserveAspectRatio="none" '
        f'role="img" aria-label="{escape(scale.kind)} scale, in the middle {escape(middle)}">'
        f"{stops}</svg> {escape(high)}</span>"
    )


def _steps(*others: tuple[str, str, str]) -> str:
    every = (
        ("out", "Zoom out", "&minus;"),
        ("in", "Zoom in", "+"),
        ("whole", "Show the whole", "⤢"),
    )
    return (
        "<span>"
        + " ".join(
            f'<button type="button" data-step="{step}" aria-label="{label}">{sign}</button>'
            for step, label, sign in (*others, *every)
        )
        + "</span>"
    )


def _drawings(page: ResultPage) -> Iterator[str]:
    title = f"Crease pattern of {page.title}"
    yield '<section id="pattern" aria-labelledby="pattern-title">'
    yield '<h2 id="pattern-title">Crease pattern</h2>'
    yield _drawing(crease_drawing(page.scene.pattern, title))
    yield "</section>"
    for number, (name, paths) in enumerate(page.sheets.items(), 1):
        yield f'<section aria-labelledby="sheet-{number}">'
        yield f'<h2 id="sheet-{number}">{escape(name)}</h2>'
        yield _drawing(sheet_drawing(paths, name, page.colours, MOST_LINES // len(page.sheets)))
        yield "</section>"


def _assembly(page: ResultPage) -> Iterator[str]:
    if page.assembly is None:
        return
    yield '<section aria-labelledby="assembly"><h2 id="assembly">Assembly</h2>'
    yield from leaflet_html(page.assembly)
    yield "</section>"


def _drawing(drawing: Drawing) -> str:
    boxes = "".join(
        f'<label><input type="checkbox" data-layer="{layer}" checked>'
        f'<svg width="22" height="4" aria-hidden="true">'
        f'<rect width="22" height="4" fill="{colour}"/></svg>{escape(name)}</label>'
        for layer, (name, colour) in drawing.layers.items()
    )
    note = f'<p class="hint">{escape(drawing.note)}</p>' if drawing.note else ""
    return (
        f'<figure class="drawing">{drawing.svg}<div class="tools" hidden>'
        f"<fieldset><legend>Layers</legend>{boxes}</fieldset>{_steps()}</div></figure>{note}"
    )


def _numbers(page: ResultPage) -> Iterator[str]:
    report = dict(page.report)
    if "sheets" in report:
        report["minutes"] = float(sum(sheet["minutes"] for sheet in report["sheets"]))
    yield '<div class="numbers">'
    yield from _sections(report, _SHORT)
    yield "</div>"
    yield from _sections(report, _LONG)


def _sections(
    report: Mapping[str, Any], sections: Sequence[tuple[str, tuple[str, ...]]]
) -> Iterator[str]:
    for title, keys in sections:
        found = {key: report[key] for key in keys if report.get(key) not in (None, [])}
        tables = "".join(_tables(title, key, value) for key, value in _grouped(found))
        if tables:
            anchor = title.lower().replace(" ", "-")
            yield f'<section aria-labelledby="{anchor}"><h2 id="{anchor}">{title}</h2>'
            yield f'<div class="tables">{tables}</div></section>'


def _grouped(found: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Plain values of a section together, then each of its tables."""
    plain = {key: value for key, value in found.items() if not isinstance(value, Mapping | list)}
    if plain:
        yield "", plain
    yield from ((key, value) for key, value in found.items() if key not in plain)


def _tables(title: str, key: str, value: Any) -> str:
    caption = key.replace("_", " ").removesuffix(" mm").capitalize() or title
    if key == "plates":
        plates = [
            {"plate": number, **part}
            for number, parts in enumerate(value["plates"], 1)
            for part in parts
        ]
        return rows_table("Parts on plates", plates) + rows_table(
            "Assembly order", value["assembly"]
        )
    if isinstance(value, Mapping):
        return mapping_table(caption, value)
    return rows_table(caption, value)


def _files(page: ResultPage) -> Iterator[str]:
    if not page.files:
        return
    yield '<section aria-labelledby="files"><h2 id="files">Files</h2>'
    yield '<div class="wide" tabindex="0" role="group" aria-label="Files"><table><thead><tr>'
    yield '<th scope="col">file</th><th scope="col">bytes</th><th scope="col">SHA-256</th>'
    yield "</tr></thead><tbody>"
    for name, data in page.files.items():
        yield (
            f'<tr><td><a href="{escape(quote(name))}">{escape(name)}</a></td>'
            f'<td>{len(data)}</td><td class="hash">{hashlib.sha256(data).hexdigest()}</td></tr>'
        )
    yield "</tbody></table></div></section>"


def _asked(page: ResultPage) -> Iterator[str]:
    """What was asked for, and what of the report no other section shows, as it is."""
    known = {key for _, keys in (*_SHORT, *_LONG) for key in keys} | {*_ELSEWHERE}
    rest = {key: value for key, value in page.report.items() if key not in known}
    rest = {key: rest[key] for key in (*_ASKED, *rest) if key in rest}
    if rest:
        text = json.dumps(rest, indent=2, ensure_ascii=False)
        yield '<section aria-labelledby="asked"><h2 id="asked">Settings</h2>'
        yield f"<details><summary>All settings</summary><pre>{escape(text)}</pre></details>"
        yield "</section>"


def _foot() -> Iterator[str]:
    yield f"<footer><p>quadfold {__version__}</p>"
    yield "<details><summary>Licence of three.js, which draws the folded form</summary>"
    yield f"<pre>{escape(_asset('three_licence.txt'))}</pre></details></footer>"


def _smaller(picture: bytes) -> bytes:
    """A PNG file of the same picture in 64 colours."""
    from PIL import Image

    stream = io.BytesIO()
    with Image.open(io.BytesIO(picture)) as image:
        few = image.convert("RGB").quantize(_PICTURE_COLOURS, dither=Image.Dither.NONE)
        few.save(stream, format="png", optimize=True)
    return stream.getvalue()


def _asset(name: str) -> str:
    return (files("fab.viewing") / "page_assets" / name).read_text(encoding="utf-8")
