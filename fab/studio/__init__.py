"""The studio: a page in the browser that changes a job, shows its sheet, and makes its files.

`serving.serve` listens on this machine alone; `app.studio_app` answers what the page asks;
`tasks` has all that grows and makes, which runs in the process of a `worker.Worker`.
"""
