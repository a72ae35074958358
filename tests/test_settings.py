"""Whatever a user writes is taken or refused in the project's own words, never by a crash."""

import copy
import re
import tomllib
from datetime import date

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fab.catalogue import shipped
from fab.errors import InvalidJob
from fab.jobs.job import Job, parse_job
from fab.settings import apply_change, checked, read_toml
from fab.sheets.materials import Machine, Material

DOCUMENTS = [
    (model, tomllib.loads(shipped(kind)[name].read_text(encoding="utf-8")))
    for model, kind, name in (
        (Job, "jobs", "curved_fold"),
        (Job, "jobs", "surface_fit"),
        (Material, "materials", "plywood_3mm"),
        (Material, "materials", "card_300gsm"),
        (Machine, "machines", "co2_60w_600x400"),
    )
]
KEYS = ["kind", "bands", "perforation", "relief", "mountain", "unknown", "kerf_mn"]
scalars = st.sampled_from(
    [
        True,
        0,
        -1,
        1.5,
        float("nan"),
        float("inf"),
        10**400,
        "",
        "x" * 200,
        "dashes",
        date(2020, 1, 1),
    ]
)
values = st.recursive(
    scalars,
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from([*KEYS, "from_deg", "to_deg", "cut_mm"]), inner, max_size=3
        )
    ),
    max_leaves=5,
)


@st.composite
def spoilt(draw):
    """A shipped document with one to three values put in anywhere."""
    model, document = draw(st.sampled_from(DOCUMENTS))
    document = copy.deepcopy(document)
    for _ in range(draw(st.integers(1, 3))):
        table = document
        while True:
            key = draw(st.sampled_from([*table, *KEYS]))
            if not (isinstance(table.get(key), dict) and table[key] and draw(st.booleans())):
                break
            table = table[key]
        table[key] = draw(values)
    return model, document


@given(spoilt())
def test_documents_are_taken_or_refused_in_words_of_our_own(case):
    model, document = case
    before = copy.deepcopy(document)
    try:
        checked(model, document, "mine.toml", "Begin anew.")
    except InvalidJob as error:
        lines = str(error).splitlines()
        assert lines[0].startswith("mine.toml: ")
        assert all(line.endswith((".", "?")) for line in lines)
        words = str(error).lower()
        assert not any(word in words for word in ("input should", "pydantic", "field required"))
    assert repr(document) == repr(before)


def test_every_fault_is_named_with_its_bound_and_cure():
    _, document = DOCUMENTS[-1]
    wrong = {**document, "kerf_mm": -1, "margin_mm": "5", "profile": "dashed", "bed": [1.0, 2.0]}
    with pytest.raises(InvalidJob) as caught:
        checked(Machine, wrong, "mine.toml", "Begin anew.")
    assert str(caught.value).splitlines() == [
        "mine.toml: margin_mm = '5' is out of bounds: it must be a number, at least 0 and at most "
        "500. Correct it (of the bed, on all sides, kept free).",
        "kerf_mm = -1 is out of bounds: it must be at least 0 or be a list, such as [1.0, 2.0]. "
        "Correct it (width of material that a cut takes away; [x, y] where the beam is wider along "
        "one axis of the bed: cuts along y are x wide, and cuts along x are y wide).",
        "profile = 'dashed' is out of bounds: it must be 'pre_dashed' or 'whole_lines'. Correct it "
        "(creases as dashes, or as whole lines for software that perforates by itself).",
        "bed is not a known key. Did you mean bed_mm? Known here: bed_mm, colours, description, "
        "dxf_version, kerf_mm, kind, knife, margin_mm, powers, profile, s_max, speeds, "
        "starting_points, stroke_mm.",
    ]
    with pytest.raises(InvalidJob, match=r"description is missing. Add it .one line.*. Begin anew"):
        checked(Machine, {}, "mine.toml", "Begin anew.")


def test_errors_list_the_first_of_many_keys_and_shorten_long_ones():
    _, document = DOCUMENTS[0]
    many = {**document, "outputs": ["x", "dxf"] * 1000}
    with pytest.raises(InvalidJob) as caught:
        checked(Job, many, "mine.toml", "Begin anew.")
    lines = str(caught.value).splitlines()
    assert len(lines) == 51
    assert lines[0].startswith("mine.toml: outputs.0 = 'x' is out of bounds")
    assert lines[-1] == "950 other keys are at fault."
    with pytest.raises(InvalidJob) as caught:
        checked(Job, {**document, "x" * 10**5: 1}, "mine.toml", "Begin anew.")
    assert len(str(caught.value)) < 1000


@pytest.mark.parametrize("document", [[], None, 3])
def test_documents_that_are_no_tables_are_refused(document):
    with pytest.raises(InvalidJob, match=rf"^job: {re.escape(str(document))} must be a table of"):
        parse_job(document)


def test_toml_with_a_mark_of_its_byte_order_is_read(tmp_path):
    path = tmp_path / "marked.toml"
    path.write_bytes(b"\xef\xbb\xbfa = 1\r\n")
    assert read_toml(path, "") == {"a": 1}


def test_whole_numbers_that_no_message_can_name_are_refused(tmp_path):
    """Python reads thousands of hexadecimal digits, and does not write that number."""
    path = tmp_path / "mine.toml"
    for value in ("0x" + "f" * 5000, "[{a = 0b1" + "0" * 20_000 + "}]"):
        path.write_text(f"kerf_mm = {value}")
        with pytest.raises(InvalidJob, match=r"a whole number has thousands of digits\. Correct"):
            read_toml(path, "")
        document: dict[str, str] = {}
        apply_change(document, f"kerf_mm={value}")
        assert document == {"kerf_mm": value}


def test_numbers_of_numpy_are_taken_as_pythons_own():
    design = {"kind": "miura", "rows": np.int64(6), "fold_deg": np.float32(30)}
    taken = {"name": "m", "design": design, "sheet": {"width_mm": np.array(90)}}
    plain = {**taken, "design": {**design, "rows": 6, "fold_deg": 30.0}, "sheet": {"width_mm": 90}}
    assert parse_job(taken) == parse_job(plain)
    with pytest.raises(InvalidJob, match=r"design.rows = 6.5 .* whole number"):
        parse_job({**taken, "design": {**design, "rows": np.float64(6.5)}})
