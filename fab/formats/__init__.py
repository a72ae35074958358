"""Files of other programs, in and out.

- `reading` chooses the reader of a file: `read_pattern_file(path, ReadOptions)`, a `PatternFile`
- readers of drawings give a `LineSoup`: `svg_reader`, `dxf_reader`, `cp`, `opx`, `ori`
- `line_letters` has the meaning of colours and layer names, `dashes` joins dashes to creases
- `importer` makes a crease pattern of such lines, by `planar_lines`, `drawn_border`, `drawn_sheet`
  and `sheet_pattern`; `strictness` has the findings that are no repairs
- FOLD: `fold_reader`, `fold_frames`, `fold_faces`, `flat_frames`, `unfolding`, `fold_writer`
- `obj_patterns` and `obj` for meshes; `conversion` writes patterns for other programs
- `surface` reads surfaces to fit, in a process of their own: `own_process`, `step_faces`
"""
