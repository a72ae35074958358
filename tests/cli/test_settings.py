"""The user's own settings and stock: kept, told, taken where none is given, never half-written."""

import errno

import pytest
from click.testing import CliRunner
from helpers import ROOT, TEMPLATES

from fab.cli.group import main
from fab.preferences import preferences_file

FILE = str(ROOT / "tests" / "patterns" / "square_twist.fold")


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "settings"))


def run(*words):
    return CliRunner().invoke(main, [str(word) for word in words])


def test_what_is_set_is_shown_and_can_be_removed():
    assert "material        -" in run("settings").stdout
    assert not preferences_file().exists()
    assert run("settings", "set", "material", "card_300gsm").exit_code == 0
    assert "material        card_300gsm" in run("settings").stdout
    assert run("settings", "unset", "material").exit_code == 0
    assert "material        -" in run("settings").stdout
    assert [path.name for path in preferences_file().parent.iterdir()] == ["settings.toml"]


def test_comments_and_other_settings_stay():
    path = preferences_file()
    path.parent.mkdir(parents=True)
    path.write_text('# at home\nprinter = "prusa_mk4s"\n')
    assert run("settings", "set", "machine", "knife_a4").exit_code == 0
    assert path.read_text() == '# at home\nprinter = "prusa_mk4s"\nmachine = "knife_a4"\n'
    path.write_bytes(b'\xef\xbb\xbfprinter = "prusa_mk4s"\n')  # as editors of Windows write it
    assert run("settings", "set", "machine", "knife_a4").exit_code == 0
    assert path.read_text() == 'printer = "prusa_mk4s"\nmachine = "knife_a4"\n'


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("material", "prusa_mk4s"), "material 'prusa_mk4s' must be one of"),
        (("machine", "card_300gsm"), "machine 'card_300gsm' must be one of"),
        (("printer", "knife_a4"), "is a cutter, not a printer"),
        (("print_material", "card_300gsm"), "is a sheet, not a print"),
        (("machin", "knife_a4"), "'machin' is no setting; it must be one of material, machine"),
    ],
)
def test_what_does_not_exist_is_not_set(words, said):
    result = run("settings", "set", *words)
    assert result.exit_code == 2
    assert said in result.stderr
    assert not preferences_file().exists()


def test_sheets_are_cut_from_the_stock_that_is_set_and_this_is_told(tmp_path):
    refused = run("fabricate", FILE, "--dry-run")
    assert refused.exit_code == 2
    assert "no material is given: add --material NAME, or set it once for all" in refused.stderr
    run("settings", "set", "material", "card_300gsm")
    run("settings", "set", "machine", "co2_60w_600x400")
    made = run("fabricate", FILE, "--only", "dxf", "--out", tmp_path / "a")
    assert made.exit_code == 0
    assert "material = card_300gsm, of your settings" in made.stderr
    given = ("--material", "card_300gsm", "--machine", "co2_60w_600x400")
    told = run("fabricate", FILE, "--only", "dxf", "--out", tmp_path / "b", *given)
    assert "of your settings" not in told.stderr
    for path in (tmp_path / "a").glob("*.dxf"):
        assert path.read_bytes() == (tmp_path / "b" / path.name).read_bytes()


def test_panels_are_printed_with_the_printer_that_is_set_unless_another_is_given():
    run("settings", "set", "printer", "prusa_mk4s")
    assert "printer = prusa_mk4s, of your settings" in run("thicken", FILE, "--dry-run").stderr
    other = run("thicken", FILE, "--dry-run", "--set", "printer.machine=ender_3")
    assert "of your settings" not in other.stderr


def test_files_of_a_folder_of_ones_own_are_known_by_name():
    folder = preferences_file().parent / "materials"
    folder.mkdir(parents=True)
    card = (TEMPLATES / "materials" / "card_300gsm.toml").read_text()
    (folder / "my_card.toml").write_text(card)
    (folder / "broken.toml").write_text("kind = ")
    listed = run("shipped", "materials").stdout
    assert f"(yours: {folder / 'my_card.toml'})" in listed
    made = run(
        *("fabricate", FILE, "--dry-run"),
        *("--material", "my_card", "--machine", "co2_60w_600x400"),
    )
    assert made.exit_code == 0
    broken = run("fabricate", FILE, "--material", "broken", "--machine", "co2_60w_600x400")
    assert broken.exit_code == 2
    assert "broken.toml" in broken.stderr


def test_a_faulty_file_is_refused_and_not_written_over():
    path = preferences_file()
    path.parent.mkdir(parents=True)
    path.write_text("matrial = 1\n")
    for words in (("settings",), ("settings", "set", "material", "card_300gsm")):
        result = run(*words)
        assert result.exit_code == 2
        assert "matrial" in result.stderr
    assert path.read_text() == "matrial = 1\n"


def test_a_folder_that_cannot_be_written_is_named():
    place = preferences_file().parent
    place.parent.mkdir(parents=True)
    place.write_text("a file where the folder is to be")
    result = run("settings", "set", "material", "card_300gsm")
    assert result.exit_code == 2
    assert f"{preferences_file()}: cannot be written" in result.stderr


def test_a_full_disk_leaves_the_file_as_it_was_and_no_other(monkeypatch):
    run("settings", "set", "material", "card_300gsm")
    before = preferences_file().read_bytes()

    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("fab.preferences.Path.replace", full)
    result = run("settings", "set", "machine", "knife_a4")
    assert result.exit_code == 2
    assert "No space left on device. Make room there" in result.stderr
    assert preferences_file().read_bytes() == before
    assert [path.name for path in preferences_file().parent.iterdir()] == ["settings.toml"]
