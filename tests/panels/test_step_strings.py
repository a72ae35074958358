"""Names of any script in STEP files: ASCII with escapes, and what OpenCASCADE reads back."""

import re

import pytest
from build123d import import_step
from hypothesis import given
from hypothesis import strategies as st
from thick_sheets import miura_pattern, thick

from fab.panels.step import step_bytes
from fab.panels.step_strings import escaped, with_tokens


def decoded(text: str) -> str:
    """The characters of a string by ISO 10303-21."""
    width = {"2": 4, "4": 8}
    return re.sub(
        r"\\X([24])\\([0-9A-F]+)\\X0\\",
        lambda m: "".join(
            chr(int(m[2][i : i + width[m[1]]], 16)) for i in range(0, len(m[2]), width[m[1]])
        ),
        text,
    )


def broken(text: str, columns: int) -> str:
    """Lines broken anywhere, as OpenCASCADE does."""
    return "\n".join(text[i : i + columns] for i in range(0, len(text), columns))


printable = st.text(st.characters(categories=["L", "N", "P", "S"], exclude_characters="\\"))


@given(printable, st.integers(3, 80))
def test_every_name_comes_back_through_broken_lines(name, columns):
    held = with_tokens(name)
    assert held.isascii()
    file = escaped(broken(held, columns))
    assert file.isascii()
    assert decoded(file.replace("\n", "")) == name


def test_what_is_no_text_is_an_underscore():
    assert with_tokens("a\x1b\udce4b") == "a__b"


@pytest.mark.parametrize(
    "name",
    ["fälten", "折り紙のとても長い名前の展開図" * 6, "a" * 100 + "ä" * 60, "~ 😀 x'y", "plain"],
)
def test_cad_programs_read_the_name(name, tmp_path):
    sheet = thick(miura_pattern(2, 2))
    data = step_bytes(sheet, name)
    assert data.isascii()
    assert data == step_bytes(sheet, name)
    path = tmp_path / "sheet.step"
    path.write_bytes(data)
    read = import_step(path)
    assert read.label.replace("_", " ") == name
    assert len(read.solids()) == len(sheet.names)
