"""Letters of creases for which a file has none, where flat folding leaves one possibility only."""

from __future__ import annotations

from fab.errors import Finding, Severity, counted, first_few
from fab.formats.drawn.fold_angles import full_fold_deg
from fab.formats.drawn.lines import Lines, listed
from fab.formats.read_options import ReadOptions
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.forced_letters import ForcedLetters, forced_letters, with_letters
from solver.vectors import FloatArray

__all__ = ["lettered"]


def lettered(
    pattern: CreasePattern, lines: Lines, origin: FloatArray, options: ReadOptions
) -> tuple[CreasePattern, list[Finding]]:
    """The pattern with the letters that follow from the others, where `options.assign`.

    lines : the edges of the pattern, in its order. origin : its lower left corner in the file, mm,
    shape (2,). Without the option a finding says how many could be assigned.
    """
    if not (pattern.edges_assignment == "U").any():
        return pattern, []
    full = full_fold_deg(options)
    forced = forced_letters(pattern, full)
    count = len(forced.edges)
    creases = first_few(sorted(lines.number[forced.edges].tolist()))
    if not options.assign:
        if not count or len(forced.contradictory):  # such a sheet need not fold flat
            return pattern, []
        text = (
            f"{counted(count + forced.free, 'crease')} without a letter, of which {count} can have "
            "one letter only if the sheet folds flat: give --assign to take it."
        )
        return pattern, [Finding("letters-assignable", Severity.NOTE, text, creases)]
    findings = []
    if count or forced.free:
        text = "no letter follows from those that are given"
        if count:
            text = f"{lines.named(forced.edges)} without a letter: assigned M or V, the only "
            text += f"possibility where the sheet folds flat, and folded by {full:g} degrees"
        text += f"; {counted(forced.free, 'crease')} {_stay(forced.free)} unassigned (U)"
        text += _open(forced)
        findings.append(Finding("letters-assigned", Severity.NOTE, text, creases))
    wrong = forced.contradictory
    if len(wrong):
        where = lines.point(origin + pattern.vertices_coords[wrong[0]])
        several = len(wrong) > 1
        text = (
            f"{listed('vertex', wrong, 'vertices')}, {'the first ' if several else ''}at {where}: "
            "no mountains and valleys around "
            f"{'them' if several else 'it'} fold flat with the letters that are given: nothing is "
            "assigned from there."
        )
        findings.append(Finding("letters-contradict", Severity.WARNING, text))
    return with_letters(pattern, forced, full), findings


def _stay(count: int) -> str:
    return "stays" if count == 1 else "stay"


def _open(forced: ForcedLetters) -> str:
    """What is reported of vertices that do not fold flat."""
    count = len(forced.open_vertices)
    if not count:
        return "."
    verb = "does" if count == 1 else "do"
    return f"; {counted(count, 'vertex', 'vertices')} {verb} not fold flat (Kawasaki)."
