"""Meshes and CAD models: as crease patterns, and as surfaces that a sheet is fitted to.

`obj` reads and writes OBJ files, `obj_patterns` makes patterns of them. `surface` reads surfaces,
in a process of their own (`own_process`); `step_faces` reads faces of STEP files as `spline_face`s.
"""
