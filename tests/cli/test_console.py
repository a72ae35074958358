"""Findings at the terminal: the most severe of each code, errors before warnings and notes."""

from shared_cases import shared_case

from fab.cli.answering import exit_code
from fab.cli.console import tell
from fab.errors import Finding, Severity
from fab.interrupts import Interrupts
from fab.outputs import Made

NOTE, WARNING, ERROR = Severity


def lines(capsys, *found):
    tell([Finding(code, severity, text) for code, severity, text in found])
    return capsys.readouterr().err.splitlines()


def test_the_most_severe_finding_of_a_code_is_shown(capsys):
    shown = lines(
        capsys,
        ("overlap", NOTE, "a"),
        ("overlap", ERROR, "b"),
        ("overlap", WARNING, "c"),
        ("overlap", ERROR, "d"),
    )
    assert shown == ["error: overlap: b (and 3 more of these)"]


def test_errors_come_first_and_equals_keep_their_order(capsys):
    shown = lines(
        capsys,
        ("n1", NOTE, "."),
        ("w1", WARNING, "."),
        ("e1", ERROR, "."),
        ("n2", NOTE, "."),
        ("w2", WARNING, "."),
        ("w1", ERROR, "!"),
        ("e2", ERROR, "."),
    )
    order = ["error: w1: ! (and 1 more of these)", "error: e1: .", "error: e2: ."]
    assert shown == [*order, "warning: w2: .", "note: n1: .", "note: n2: ."]


def test_an_exit_code_of_1_has_an_error_on_the_terminal(capsys, tmp_path):
    """The crane whose overlap between states was shown in place of the one that failed it."""
    path = shared_case("crane_plain.fold")
    from fab import read_pattern
    from fab.jobs.print_files import ThickFormat, make_thick
    from fab.pattern.crease_pattern import scaled
    from fab.printing.thick_settings import thick_settings

    pattern = scaled(read_pattern(path)[0], width_mm=200.0)
    settings = thick_settings(["panels.fold_limit_deg=120.0"])
    made: Made = make_thick(pattern, "crane", settings, formats=[ThickFormat.STL])
    assert not made.within_tolerance
    tell(made.findings)
    assert capsys.readouterr().err.startswith("error: solids-overlap: ")


def test_words_of_wrong_usage_are_shown_without_what_a_terminal_obeys(capfd):
    for words in (["\x1b[31mx"], ["convert", "--\x07x"], ["simulate", "a.svg", "--down", "1\x0b"]):
        assert exit_code(words, Interrupts()) == 2
        told = capfd.readouterr().err
        assert ascii(words[-1])[1:-1] in told
        assert all(letter.isprintable() or letter == "\n" for letter in told)
