"""Drawings: cut paths by operation, and their files. Knows nothing of patterns.

- `cut_paths`: lines by operation (`CutPaths`, `Layer`, `Operation`).
- `layer_colours`: the colour of each operation.
- `cut_settings`: speed and power of each operation.
- `drawing_files`: files in the formats asked for; a new format is added to `SheetFormat`.
- `dxf`, `svg`, `pdf`, `lightburn`, `plotter`, `gcode`: a writer each.
- `number_records`: millions of numbers as text.
"""
