"""Files of other programs, in and out.

- `reading` chooses the reader of a file: `read_pattern_file(path, ReadOptions)`, a `PatternFile`
- `read_options`, `pattern_file` and `strictness` say what is asked for, what comes of it, and which
  findings are repairs
- `source_files`, `coordinate_bounds` and `units` serve all readers

| package | files |
|---|---|
| `drawn` | of none: the lines of any drawing, and how they become a crease pattern |
| `svg`, `dxf` | drawings of these formats |
| `oripa` | of ORIPA and its relatives: CP, OPX, ORI, ORH |
| `fold` | FOLD: listed faces, frames, folded forms that unfold |
| `meshes` | patterns in OBJ files; surfaces to fit, in STL, OBJ, PLY and STEP files |
"""
