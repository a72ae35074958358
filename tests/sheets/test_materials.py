"""Materials and machines: every shipped file, files of the user's own, and every refusal."""

import tomllib

import pytest
from click.testing import CliRunner

from fab.catalogue import known_of
from fab.cli.group import main
from fab.drawings.cut_paths import Operation
from fab.errors import InvalidJob
from fab.sheets.crease_styles import DashStyle, ScoreStyle
from fab.sheets.materials import load_machine, load_material, perforation_for
from fab.sheets.perforation_settings import FoldBand, PerforationSettings
from fab.sheets.relief_holes import ReliefSettings

MATERIALS, MACHINES = known_of("sheet"), known_of("cutter")


def test_all_that_is_promised_is_shipped():
    assert set(MATERIALS) == {
        "copy_paper_80gsm",
        "card_300gsm",
        "corrugated_board",
        "polypropylene_0.5mm",
        "pet_film_0.19mm",
        "plywood_3mm",
        "acrylic_2mm",
        "stainless_0.5mm_half_etched",
    }
    assert {name.split("_")[0] for name in MACHINES} == {"co2", "diode", "fibre", "knife"}
    listed = CliRunner().invoke(main, ["templates"]).output
    assert not any(name in listed for name in [*MATERIALS, *MACHINES])


@pytest.mark.parametrize("name", MATERIALS)
def test_every_material_is_sound(name):
    material = load_material(name)
    named = float(name.rpartition("mm")[0].rpartition("_")[2]) if "mm" in name else None
    assert named is None or material.thickness_mm == named
    relief = material.perforation.relief
    assert relief is None or relief.web_mm >= material.thickness_mm or material.thickness_mm >= 2
    grams = {"copy_paper_80gsm": 80, "card_300gsm": 300}.get(name)
    assert grams is None or material.grams_per_m2 == pytest.approx(grams, rel=1e-3)
    for style in (material.perforation.mountain, material.perforation.valley):
        lengths = {f"perforation.mountain.{key}" for key in style.model_dump() if key != "kind"}
        assert style is material.perforation.valley or lengths <= set(material.starting_points)
    rigid = name in ("plywood_3mm", "acrylic_2mm")
    assert (material.perforation.mountain.kind == "lattice") == rigid
    assert (material.bend_radius_mm is None) == rigid


@pytest.mark.parametrize("name", MACHINES)
def test_every_machine_is_sound(name):
    machine = load_machine(name)
    assert all(0 < room < side for room, side in zip(machine.room_mm, machine.bed_mm, strict=True))
    if "x" in name.rpartition("_")[2]:
        assert list(machine.bed_mm) == [float(x) for x in name.rpartition("_")[2].split("x")]
    assert (machine.kerf_mm == 0) == name.startswith("knife")
    speeds = machine.speeds
    assert speeds.perforate_mm_s <= speeds.cut_mm_s <= speeds.travel_mm_s
    assert "speeds.cut_mm_s" in machine.starting_points
    seen = [machine.colours.of(operation) for operation in Operation]
    assert (
        len({colour.hex for colour in seen})
        == len({colour.aci for colour in seen})
        == len(Operation)
    )


@pytest.mark.parametrize("path", [*MATERIALS.values(), *MACHINES.values()], ids=lambda p: p.stem)
def test_every_number_names_its_unit(path):
    units = (
        *("_mm", "_mm_s", "_s", "_kg_m3", "_mpa", "_n", "_ratio", "_deg"),
        *("rows", "aci", "strain_max"),
    )

    def walk(table):
        for key, value in table.items():
            if isinstance(value, dict):
                walk(value)
            elif isinstance(value, float | int) or key == "bed_mm":
                assert key.endswith(units), key

    walk(tomllib.loads(path.read_text()))


def test_whole_lines_are_scores_on_the_layers_of_their_assignments():
    material = load_material("card_300gsm")
    whole = perforation_for(load_machine("diode_10w_400x400"), material)
    assert whole.mountain == whole.valley == ScoreStyle()
    assert whole.margin_mm == material.perforation.margin_mm
    dashed = perforation_for(load_machine("co2_60w_600x400"), material)
    assert dashed == material.perforation
    assert perforation_for(load_machine("co2_60w_600x400"), material, scored=True) == whole
    banded = material.perforation.model_copy(
        update={"bands": [FoldBand(from_deg=0, to_deg=90, valley=DashStyle(cut_mm=1, gap_mm=1))]}
    )
    many = material.model_copy(update={"perforation": banded})
    assert perforation_for(load_machine("diode_10w_400x400"), many) == whole


def test_a_file_of_the_users_own_is_taken_by_its_path(tmp_path):
    text = MACHINES["co2_60w_600x400"].read_text().replace("kerf_mm = 0.15", "kerf_mm = 0.21")
    (tmp_path / "mine.toml").write_text(text)
    assert load_machine(tmp_path / "mine.toml").kerf_mm == 0.21
    assert load_machine(str(tmp_path / "mine.toml")).bed_mm == (600, 400)


def refusal(tmp_path, load, text: str) -> str:
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises(InvalidJob) as caught:
        load(path)
    assert str(path) in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    ("name", "old", "new", "match"),
    [
        ("co2_60w_600x400", "kerf_mm = 0.15", "kerf_mm = -0.1", "kerf_mm = -0.1 is out of bounds"),
        ("co2_60w_600x400", "kerf_mm = 0.15", "kerf_mm = nan", "kerf_mm = nan is out of bounds"),
        ("co2_60w_600x400", "kerf_mm = 0.15", "kerf_mn = 0.1", "Did you mean kerf_mm?"),
        ("card_300gsm", "tab_mm", "rotations_deg = []\ntab_mm", "must have 1 values or more"),
        (
            "card_300gsm",
            "tab_mm",
            'rotations_deg = "half turn"\ntab_mm',
            "must be one of any, half turns, none, or a list of angles. Did you mean half turns?",
        ),
        (
            "card_300gsm",
            "tab_mm",
            "rotations_deg = [0.0, 720.0]\ntab_mm",
            "rotations_deg.1 = 720.0 is out of bounds: it must be at least -360 and at most 360.",
        ),
        ("co2_60w_600x400", "kerf_mm = 0.15", "", "kerf_mm is missing"),
        ("co2_60w_600x400", "pierce_s = ", "pierce_ms = ", "Did you mean speeds.pierce_s?"),
        ("co2_60w_600x400", "margin_mm = 5.0", "margin_mm = 200.0", "must be below 200"),
        ("co2_60w_600x400", "[600.0, 400.0]", "[600.0, 0.0]", "both sides"),
        ("co2_60w_600x400", "[600.0, 400.0]", "[600.0]", "bed_mm"),
        ("co2_60w_600x400", '"pre_dashed"  #', '"dashed"  #', "'pre_dashed' or 'whole_lines'"),
        ("co2_60w_600x400", '"R2000"', '"R13"', "'R12', 'R2000'"),
        ("co2_60w_600x400", '"#ff0000"', '"red"', "colours.mountain.hex = 'red' is out of bounds"),
        ("co2_60w_600x400", "aci = 7", "aci = 256", "colours.cut.aci = 256 is out of bounds"),
        ("co2_60w_600x400", '"kerf_mm"', '"kerf"', "starting_points names kerf, which is no key"),
        (
            "card_300gsm",
            "thickness_mm = 0.36",
            "thickness_mm = 0",
            "thickness_mm = 0 is out of bounds",
        ),
        (
            "card_300gsm",
            "thickness_mm = 0.36",
            'thickness_mm = "0.3"',
            "'0.3' is out of bounds: it must be a number",
        ),
        ("card_300gsm", 'kind = "dashes"', 'kind = "dashed"', "Did you mean dashes?"),
        (
            "card_300gsm",
            "cut_mm = 3.0",
            "cut_mm = 0.001",
            "0.001 is out of bounds: it must be at least 0.01",
        ),
        (
            "card_300gsm",
            "cut_mm = 3.0",
            "cuts_mm = 3.0",
            "mean perforation.mountain.cut_mm?",
        ),
        (
            "card_300gsm",
            "cut_mm = 3.0",
            'cut_mm = "3"',
            "cut_mm = '3' is out of bounds: it must be a num",
        ),
        (
            "plywood_3mm",
            "rows = 5",
            "rows = 5.5",
            "must be a whole number, at least 2",
        ),
        (
            "plywood_3mm",
            "rows = 5",
            "rows = 0",
            "must be at least 2 and at most 100",
        ),
        ("co2_60w_600x400", "[600.0, 400.0]", "[600.0, nan]", "bed_mm.1 = nan is out of bounds"),
        ("co2_60w_600x400", "[600.0, 400.0]", "[600.0]", "bed_mm has too few values"),
        ("co2_60w_600x400", "[600.0, 400.0]", "600.0", "must be a list, such as [1.0, 2.0]"),
        ("co2_60w_600x400", "cut_mm_s = 50.0", "cut_mm_s = 0", "must be greater than 0 and at"),
        (
            "co2_60w_600x400",
            "cut_mm_s = 50.0",
            f"cut_mm_s = {'9' * 400}",
            "999... is out of bounds",
        ),
        ("co2_60w_600x400", "cut_mm_s = 50.0", f"cut_mm_s = {'9' * 5000}", "not a TOML file"),
        ("co2_60w_600x400", "cut_mm_s = 50.0", "cut_mm_s = 2020-01-01", "must be a number"),
        (
            "co2_60w_600x400",
            "cut_mm_s = 50.0",
            "cut_mm_s = true",
            "True is out of bounds: it must be a",
        ),
        ("co2_60w_600x400", "[speeds]", "[speed]", "Did you mean speeds?"),
        ("co2_60w_600x400", "kerf_mm = 0.15", "cut_mm_s = 3.0", "Did you mean speeds.cut_mm_s?"),
        ("co2_60w_600x400", "[speeds]", "speeds = 3\n[colour]", "speeds = 3 must be a table"),
        ("card_300gsm", "gap_mm = 1.0", "gap_mm = -inf", "must be a finite number, at least 0.01"),
        ("card_300gsm", "cut_mm = 3.0", "cut_mm = 2000.0", "at most 1000. Correct it (length of"),
        ("card_300gsm", 'kind = "dashes"', "kind = 3", "perforation.mountain.kind = 3 must be one"),
        ("card_300gsm", "margin_mm = 0.5", "", "margin_mm must be given in a material"),
        ("card_300gsm", "[perforation.mountain]", "[perforation.flat]", "mountain must be given"),
        ("card_300gsm", 'description = "', 'description = ""  # "', "must not be empty"),
        ("card_300gsm", 'description = "', 'description = 3  # "', "must be text in quotes"),
        (
            "plywood_3mm",
            "web_mm = 2.0",
            "web_mm = 0",
            "perforation.relief.web_mm = 0 is out of bounds",
        ),
        ("plywood_3mm", "gap_mm = 3.0", "gap_mm = 30.0", "Lower gap_mm."),
        ("card_300gsm", "description =", "description", "not a TOML file"),
    ],
)
def test_files_that_cannot_be_right_are_refused(tmp_path, name, old, new, match):
    path = (MATERIALS | MACHINES)[name]
    text = path.read_text()
    assert old in text
    load = load_material if name in MATERIALS else load_machine
    assert match in refusal(tmp_path, load, text.replace(old, new, 1))


def test_unknown_names_are_given_the_close_one(tmp_path):
    with pytest.raises(InvalidJob, match="Did you mean card_300gsm"):
        load_material("card300")
    with pytest.raises(InvalidJob, match="material 'xyz' must be one of acrylic_2mm, "):
        load_material("xyz")
    with pytest.raises(InvalidJob, match="Did you mean knife_a4"):
        load_machine("knife_A4")


@pytest.mark.parametrize("key", ["material", "machine"])
def test_files_that_are_none_give_exit_code_2_and_write_nothing(tmp_path, key):
    (tmp_path / "folder.toml").mkdir()
    (tmp_path / "large.toml").write_bytes(b"# \n" * 400_000)
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "deep.toml").write_text("a = " + "[" * 100_000)
    (tmp_path / "loop.toml").symlink_to(tmp_path / "loop.toml")
    (tmp_path / "empty.toml").touch()
    files = {
        "missing.toml": "No such file or directory. Check the path",
        "folder.toml": f"not a file. Check the path, or list the names: `quadfold shipped {key}s`",
        "large.toml": "has 1200000 bytes, must have at most 1000000.",
        "bytes.toml": "not a TOML file",
        "deep.toml": "not a TOML file",
        "loop.toml": "cannot be read",
        "empty.toml": "description is missing. Add it (one line",
        "../../etc/passwd": "must be one of",
        "..": "must be one of",
        "": "must be one of",
    }
    for name, text in files.items():
        whole = {"material": "card_300gsm", "machine": "co2_60w_600x400"}
        whole[key] = str(tmp_path / name) if name.endswith(".toml") else name
        words = [f"--{word}={value}" for word, value in whole.items()]
        result = CliRunner().invoke(main, ["coupon", *words, "--out", str(tmp_path / "out")])
        assert result.exit_code == 2, result.output
        assert text in result.output, name
        assert "pydantic" not in result.output
        assert not (tmp_path / "out").exists()


def test_what_a_material_leaves_out_is_as_in_a_job():
    perforation = load_material("card_300gsm").perforation
    assert perforation.flat == PerforationSettings().flat
    assert perforation.relief is None
    relief = load_material("plywood_3mm").perforation.relief
    assert relief == ReliefSettings(web_mm=2.0, radius_mm=1.5)
