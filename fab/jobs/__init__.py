"""Jobs: from a design or a mesh to all its files.

What a command makes is in a module of its own, where the branches join: `job_files` (run),
`sheet_files` (fabricate), `print_files` (thicken), `folding_files` (simulate), `animation_files`
(animate), `conversion`, `figure_files` (figure), whose figures are in `paper_figures` and their
data in `paper_models`.

`job_files` joins `job_parts` (what is measured), `job_drawings` and `job_products` of a
`folded_sheet`. `job` has the tables of a job, `design_settings` and `own_designs` those of its
design; `grow` makes the crease pattern. `suggestion` finds feasible thicknesses and sizes,
`pattern_check` measures patterns of any origin, `file_names` has the names of all files.
"""
