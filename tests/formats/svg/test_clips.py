"""Clip paths hide lines that are read all the same: with a warning, where they do."""

import pytest

from fab.errors import Severity
from fab.formats.read_options import ReadOptions
from fab.formats.svg.reader import read_svg

CREASE = '<path d="M0 30H100" stroke="blue"/>'
HALF = '<rect width="50" height="60"/>'


def finding(tmp_path, clip, drawn):
    path = tmp_path / "clipped.svg"
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="60mm" viewBox="0 0 100 60" '
        f'fill="none" stroke="black"><defs><path id="tall" d="M0 0H50V60H0z"/>'
        f'<clipPath id="c"{clip}</clipPath></defs><rect width="100" height="60"/>{drawn}</svg>'
    )
    soup = read_svg(path, ReadOptions())
    assert len(soup.lines_coords) == 4 + drawn.count("<path")  # taken whole, whatever is hidden
    return next(f for f in soup.findings if f.code == "clip-ignored")


@pytest.mark.parametrize(
    ("clip", "attributes", "middle"),
    [
        (f">{HALF}", 'clip-path="url(#c)"', "(75, 30)"),
        (f">{HALF}", "style=\"clip-path: url('#c')\"", "(75, 30)"),
        (f' transform="scale(0.5 1)">{HALF}', 'clip-path="url(#c)"', "(62.5, 30)"),
        ('><use href="#tall" x="10"/>', 'clip-path="url(#c)"', "(5, 30)"),
        ('><path d="M60 0H100V60H60"/>', 'clip-path="url(#c)"', "(30, 30)"),
        (f">{HALF}", 'clip-path="url(#c)" transform="translate(20)"', "(95, 30)"),
        (">", 'clip-path="url(#c)"', "(50, 30)"),
    ],
)
def test_what_a_clip_hides_is_a_warning_with_its_place(clip, attributes, middle, tmp_path):
    told = finding(tmp_path, clip, f"<g {attributes}>{CREASE}</g>")
    assert told.severity == Severity.WARNING
    assert f"1 line in whole or in part, the first of path 1 around {middle} mm" in told.text


@pytest.mark.parametrize(
    ("clip", "attribute"),
    [
        ('><rect width="100" height="60"/>', 'clip-path="url(#c)"'),  # its lines, not their width
        ('><rect width="50" height="60" transform="scale(2 1)"/>', 'clip-path="url(#c)"'),
        ('><rect width="50" height="60"/><use href="#tall" x="50"/>', 'clip-path="url(#c)"'),
        ("><text>x</text>", 'clip-path="url(#c)"'),  # unknown, as masks are
        (f">{HALF}", 'mask="url(#c)"'),
        (f">{HALF}", 'clip-path="url(#other)"'),
    ],
)
def test_clips_that_hide_nothing_or_are_unknown_are_noted(clip, attribute, tmp_path):
    told = finding(tmp_path, clip, f"<g {attribute}>{CREASE}</g>")
    assert told.severity == Severity.NOTE


def test_lines_that_clips_within_clips_hide_are_counted_once(tmp_path):
    drawn = f'<g clip-path="url(#c)"><g clip-path="url(#c)">{CREASE}{CREASE}</g></g>'
    told = finding(tmp_path, f">{HALF}", drawn)
    assert "hides 2 lines" in told.text
