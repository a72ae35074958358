"""Clearance of thick sheets: sound bodies that stay apart in every folded state.

- `soundness`: closed bodies in one piece, held together by their hinges
- `checked_bodies`, `promised_distances`, `pair_checks`: all pairs of bodies in one state
- `pair_findings`: pairs that overlap or come too near, as findings
- `thick_inspection`: all of these, in all states, with the figures of a report
- `thickness_limit`: the largest thickness at which no panels overlap

Nothing in this wing depends on a printer: that is `fab.printing`.
"""
