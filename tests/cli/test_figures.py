"""The command that makes the paper's figures."""

from pathlib import Path

from click.testing import CliRunner

from fab.cli.group import main


def run(*arguments):
    return CliRunner().invoke(main, ["figure", *map(str, arguments)])


def test_the_list_names_every_figure_with_its_caption():
    result = run("--list")
    assert result.exit_code == 0
    lines = result.output.splitlines()
    assert len(lines) == 18 + 10 + 1
    assert lines[12].startswith("S13  Landscapes of the cost S30")
    assert "may have other numbers in print" in lines[-1]


def test_a_figure_is_written_with_its_caption(tmp_path):
    result = run("s8", "--only", "svg", "--out", tmp_path / "out")
    assert result.exit_code == 0
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["S8.svg"]
    assert "S8: Closed fronts" in result.output
    again = run("S8", "--only", "svg", "--out", tmp_path / "dry", "--dry-run")
    assert "would write" in again.output
    assert not (tmp_path / "dry").exists()


def test_names_and_formats_that_do_not_exist_are_refused(tmp_path):
    for arguments, words in (
        (("S31",), "figure 'S31' must be one of S1, S2"),
        (("al",), "or all."),
        ((), "Name a figure such as S13, or all."),
        (("S8", "--only", "gif"), "S8 is a figure: --only must name one of png, svg."),
        (("S8", "--only", "pgn"), "Did you mean png?"),
        (("M11",), "Did you mean M1"),
        (("S8", "--out", Path(__file__)), "is a file, not a folder"),
    ):
        result = run(*arguments)
        assert result.exit_code == 2, arguments
        assert words in result.output
