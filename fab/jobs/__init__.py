"""Jobs: from a design or a mesh to all its files.

`job` has the tables of a job, `design_settings` and `own_designs` those of its design; `grow` makes
the crease pattern, `job_files` its files. `suggestion` finds feasible thicknesses and sizes,
`pattern_check` measures patterns of any origin.
"""
