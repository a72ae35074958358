"""Sweeps: many variations of a job, measured in parallel into one table.

- `axes`: values of a key; `constraints` between them; `variations`: their combinations.
- `sweep_settings`: the sweep file, its base job and its limits.
- `figures`: the row of a variation; `table_schema`: what its columns are.
- `engine`: batches of variations on processes, of this machine or a cluster.
- `parts`: rows in Parquet files, and which of them are there already.
"""
