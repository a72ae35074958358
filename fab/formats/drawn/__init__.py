"""Drawn lines, and how they become a crease pattern.

Readers of drawings give a `LineSoup` (`line_soup`): `letters` has the meaning of colours and layer
names, `dashes` joins dashes to creases, `own_sheets` takes away what we add to sheets.

`importer` makes a pattern of it: `tolerance` says how near ends are joined, `planar_lines` splits
lines where they cross, `border`, `page_frame` and `sheet` find what they enclose. `sheet_pattern`
makes the pattern of faces and the `lines` around them, with `fold_angles` and `crease_letters` that
the file lacks.
"""
