"""Thick panels of a crease pattern, the hinges between them, and their CAD models.

From a pattern to solids: `setbacks` (how far panels stay away from their creases), `inset_sides`
(what that leaves of their sides), `bevelled_panels` (the solid of each face), `hinges` (kinds,
settings, what they need), `hinge_room` (where they have room), the modules of each kind of hinge
(`webs`; `knuckles`, `barrels` and `knuckled_panels`; `film`), `alignment_holes`, `inner_edges`
(slits within a face), and `thick_sheet`, which puts all of them together. A new kind begins in
`hinges.HingeKind`.

What is feasible: `inset_limits` (exact bounds of thickness and scale), `feasibility` (faces that
can have a panel, and what saves the others), `feasible_window` (a table of these for a sheet).

For other programs: `body_colours`, `cad_assembly` (build123d objects with joints), `step`.
"""
