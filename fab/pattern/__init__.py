"""The crease pattern in millimetres, and what follows from it alone.

`crease_pattern` is the data type, with the names of the FOLD format; `development` makes the flat
sheet of a grown mesh, `overlap` compares its faces.
Of a pattern: `outlines` (what is cut through), `open_cuts` (the sheet with its cuts open),
`closing_edges` (edges that meet when folded), `sectors` (lines around vertices),
`flat_foldability` (letters that fold a vertex flat), `forced_letters` (those that follow).
Of its fold: `kinematics` and `face_tree` (rigid faces turned by the fold angles), `face_poses`,
`inspection` (exactness, as findings).
"""
