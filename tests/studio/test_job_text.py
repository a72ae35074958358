"""Texts of jobs: changed key by key, and nothing of a folder above."""

import tomllib

import pytest
from helpers import TEMPLATE_NAMES, TEMPLATES
from hypothesis import given
from hypothesis import strategies as st

from fab.errors import InvalidJob
from fab.jobs.job import load_job
from fab.studio.form_fields import form_fields
from fab.studio.job_text import changed_text, job_of_text

MIURA = (TEMPLATES / "miura.toml").read_text(encoding="utf-8")


def test_comments_and_order_stay():
    changed = changed_text(
        MIURA,
        [
            (["design", "rows"], 6),
            (["design", "sector_angle_deg"], 55),
            (["panels", "axis"], "middle"),
            (["sheet", "width_mm"], None),
            (["sheet", "folded_width_mm"], 120.0),
            (["goals", "most_fold_deg"], 170),
        ],
    )
    assert "rows = 6\n" in changed
    assert "sector_angle_deg = 55.0  # acute angle of the parallelograms\n" in changed
    comments = [line.partition("#")[2] for line in MIURA.splitlines() if "#" in line]
    kept = [line.partition("#")[2] for line in changed.splitlines() if "#" in line]
    assert kept == [text for text in comments if "longer side" not in text]
    document = tomllib.loads(changed)
    assert document["panels"]["axis"] == "middle"
    assert document["sheet"] == {"folded_width_mm": 120.0}
    assert document["goals"] == {"most_fold_deg": 170}


@pytest.mark.parametrize("name", TEMPLATE_NAMES)
def test_texts_without_changes_stay_as_they_are(name):
    text = (TEMPLATES / f"{name}.toml").read_text(encoding="utf-8")
    assert changed_text(text, []) == text
    assert job_of_text(text, TEMPLATES) == load_job(TEMPLATES / f"{name}.toml")


KEYS = st.text(min_size=1, max_size=6)
VALUES = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20)


@given(st.lists(st.tuples(st.lists(KEYS, min_size=1, max_size=3), VALUES), max_size=4))
def test_whatever_is_changed_is_toml_or_refused(changes):
    try:
        changed = changed_text(MIURA, changes)
    except InvalidJob:
        return
    document = tomllib.loads(changed)
    assert document["design"]["kind"] == "miura"


@pytest.mark.parametrize(
    ("table", "key", "value"),
    [
        ("design", "surface", "../waves.stl"),
        ("design", "surface", "/etc/passwd.stl"),
        ("design", "kind", "../mine.py:HelixFold"),
        ("printer", "machine", "../printer.toml"),
    ],
)
def test_files_outside_the_folder_are_refused(table, key, value, tmp_path):
    text = (TEMPLATES / "vase.toml").read_text(encoding="utf-8")
    with pytest.raises(InvalidJob, match="is outside"):
        job_of_text(changed_text(text, [([table, key], value)]), tmp_path)


def test_a_link_that_leaves_the_folder_is_outside(tmp_path):
    folder = tmp_path / "inner"
    folder.mkdir()
    (folder / "link.stl").symlink_to(tmp_path / "other.stl")
    text = (TEMPLATES / "vase.toml").read_text(encoding="utf-8")
    with pytest.raises(InvalidJob, match="is outside"):
        job_of_text(changed_text(text, [(["design", "surface"], "link.stl")]), folder)


def test_texts_have_a_bound():
    with pytest.raises(InvalidJob, match="at most 1000000 bytes"):
        job_of_text(MIURA + "#" * 1_000_000, TEMPLATES)


@pytest.mark.parametrize("name", ["miura", "vase", "curved_fold", "brownian_ribbon"])
def test_every_field_is_a_key_that_takes_its_own_default(name):
    text = (TEMPLATES / f"{name}.toml").read_text(encoding="utf-8")
    job = job_of_text(text, TEMPLATES)
    fields = form_fields(job)
    assert len({field.path for field in fields}) == len(fields) > 40
    changes = [(field.path, field.default) for field in fields if field.default is not None]
    given_keys = {".".join(path) for path, _ in changes}
    assert {"panels.thickness_mm", "hinges.kind", "perforation.margin_mm"} <= given_keys
    defaults = [each for each in changes if each[0][0] not in ("design", "name")]
    for group in (defaults, [each for each in changes if each[0][0] == "design"]):
        changed = job_of_text(changed_text(text, group), TEMPLATES).model_dump()
        for path, value in group:
            table = changed
            for key in path:
                table = table[key]
            assert table == value, path


def test_fields_say_what_they_are():
    fields = {".".join(each.path): each for each in form_fields(load_job(TEMPLATES / "miura.toml"))}
    assert fields["design.rows"].kind == "integer"
    assert fields["design.rows"].text == "number of quads in each direction"
    assert fields["sheet.width_mm"].unit == "mm"
    assert (fields["sheet.width_mm"].low, fields["sheet.width_mm"].high) == (0.0, 1e5)
    assert fields["hinges.kind"].choices == ("web", "knuckle", "film", "none")
    assert "prusa_mk4s" in fields["printer.machine"].choices
