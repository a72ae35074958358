"""Printing of thick sheets: printers, plates, joints, and the files of slicers.

- `printers`, `thick_settings`, `plate_settings`: what the user chooses
- `printability`: what a printer cannot print, and the figures of a print
- `plates`: sheets larger than the bed, with `dovetails` (joints of their parts), `joint_plans` (the
  outlines of joints) and `jointed_sheet` (bodies that are cut by them)
- `stl`, `threemf`: one module for each kind of file

`fab.jobs.print_files` makes all of these files, and their report.
"""
