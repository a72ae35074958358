"""The schema of reports is that of the reports that are made."""

import copy
import json

import jsonschema
import pytest
from click.testing import CliRunner
from helpers import TEMPLATES

from fab.cli.group import main
from fab.jobs.job import load_job
from fab.jobs.job_files import make
from fab.sweeps.columns import FIGURES, figures_of
from fab.sweeps.report_schema import report_schema

CUTTER = 'cutter={material = "card_300gsm", machine = "co2_60w_600x400"}'

LOADS = 'simulation.loads={fixed = ["left edge"], parts = 1, load_steps = 1}'


def report_of(name, changes=(), formats=()):
    made = make(load_job(TEMPLATES / f"{name}.toml", list(changes)), formats)
    return json.loads(json.dumps(made.report))


@pytest.fixture(scope="module")
def full():
    changes = ["simulation.steps=2", LOADS, CUTTER]
    return report_of("miura", changes, ["dxf", "stl", "fold"])


def test_the_schema_is_one():
    jsonschema.Draft202012Validator.check_schema(report_schema())
    printed = CliRunner().invoke(main, ["table", "--schema"])
    assert json.loads(printed.stdout) == report_schema()


@pytest.mark.parametrize("name", ["curved_fold", "crumpled", "brownian_ribbon", "random_tube"])
def test_reports_are_valid(name):
    jsonschema.validate(report_of(name), report_schema())


def test_every_figure_is_in_a_report_of_everything(full):
    jsonschema.validate(full, report_schema())
    figures = figures_of(full)
    # a Miura sheet follows no surface, has no print material, and has no advice to give
    assert {name for name, value in figures.items() if value is None} == {
        "growth.coverage",
        "solids.mass_g",
    }
    kinds = {"text": str, "whole": int, "number": float | int, "truth": bool}
    for column in FIGURES:
        value = figures[column.name]
        assert value is None or isinstance(value, kinds[column.kind]), column.name


@pytest.mark.parametrize("column", [c for c in FIGURES if "#" not in c.path], ids=lambda c: c.name)
def test_a_figure_of_another_type_is_not_valid(full, column):
    wrong = copy.deepcopy(full)
    place = wrong
    *path, last = [0 if key == "+" else key for key in column.path]
    for key in path:
        place = place[key]
    place[last] = {"not": "a figure"}
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(wrong, report_schema())
