"""Runs of a sweep: what is there already is not done again, and the table is written at the end."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Mapping
from concurrent.futures import CancelledError
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

from fab.errors import InvalidJob, counted
from fab.jobs.job import Job
from fab.progress import Progress, Steps, silent
from fab.settings import plain
from fab.sweeps.cluster import ClusterSettings, cluster_pool, lost_batches
from fab.sweeps.engine import Pool, run_batches
from fab.sweeps.job_text import job_bytes
from fab.sweeps.rows import Batch, row_of
from fab.sweeps.search import Search, best_rows
from fab.sweeps.sweep_folder import Listed, Plan, SweepFolder, locked
from fab.sweeps.sweep_settings import Measure, Sweep, sweep_of
from fab.sweeps.variations import Variations, variations_of
from fab.sweeps.workers import local_pool, require_parent

__all__ = ["Estimate", "SweepResult", "estimate", "run_sweep", "sweep"]

# Variations that a dry run makes, to say how long the others take.
_TRIED = 5
_MINUTE_S = 60
# Jobs of a Pareto front that are written.
_MOST_BEST = 100


@dataclass(frozen=True)
class SweepResult:
    """What a run of a sweep made.

    Attributes
    ----------
    table : the file of the whole table.
    variations, jobs : how many there are; alike variations have one job.
    begun_with : jobs whose rows were there before.
    others : rows in the folder of jobs that are not in this sweep, or of another version.
    damaged : parts that could not be read, whose jobs were done again.
    again : jobs that were done again because they crashed, or a limit ended them that is higher.
    statuses : how many variations ended in which way.
    best : names of the jobs that a search found best, written beside the table; None where it was
        no search.
    """

    table: Path
    variations: int
    jobs: int
    begun_with: int
    others: int
    damaged: int
    statuses: dict[str, int]
    best: tuple[str, ...] | None = None
    again: int = 0

    def rows(self) -> list[dict[str, Any]]:
        """The rows of the table, in the order of the variations."""
        import pyarrow.parquet as pq

        found: list[dict[str, Any]] = pq.read_table(self.table).to_pylist()
        return found

    def lines(self) -> Iterator[str]:
        """What a user should know of it, line by line."""
        if self.begun_with and self.best is None:
            yield f"{self.begun_with} of {counted(self.jobs, 'job')} were there already"
        elif self.begun_with:
            yield f"{counted(self.begun_with, 'trial')} of earlier runs"
        if self.others:
            yield f"{counted(self.others, 'row')} of other variations or versions left aside"
        if self.damaged:
            yield f"{counted(self.damaged, 'damaged part')} left aside, done again"
        if self.again:
            yield (
                f"{counted(self.again, 'job')} that had crashed, or come to a limit that is higher "
                "now, done again"
            )
        ways = ", ".join(f"{count} {status}" for status, count in self.statuses.items())
        yield f"{counted(self.variations, 'variation')}: {ways}"
        if self.best == ():
            yield "no trial was made that meets the conditions, so that none is the best"
        elif self.best is not None:
            yield f"the best: {self.table.parent / self.best[0]}" + (
                f" and {len(self.best) - 1} more" if len(self.best) > 1 else ""
            )
        yield f"wrote {self.table}, results.csv and the page {self.table.parent / 'sweep.html'}"


@dataclass(frozen=True)
class Estimate:
    """How long a sweep takes: variations, processes, and seconds of those that were tried."""

    variations: int
    workers: int
    tried: int
    seconds: float
    refused: str = ""

    def lines(self) -> Iterator[str]:
        """The same, in words."""
        each = self.seconds / self.tried
        whole = each * self.variations / self.workers
        long = f"{whole:.0f} s" if whole < 2 * _MINUTE_S else f"{whole / _MINUTE_S:.0f} min"
        yield (
            f"{counted(self.variations, 'variation')}, about {each:.2g} s each by "
            f"{counted(self.tried, 'trial')}: about {long} with "
            f"{counted(self.workers, 'process', 'processes')}"
        )
        if self.refused:
            yield f"a trial was not made: {self.refused}"


def estimate(
    sweep: Sweep, *, jobs: int | None = None, source: str = "sweep", progress: Progress = silent
) -> Estimate:
    """How many variations a sweep has, and how long they take, by a few spread over it.

    Raises `InvalidJob` as `run_sweep`.
    """
    variations = _begun(sweep, source)
    count = sum(1 for _ in variations)
    if not count:
        raise InvalidJob(f"{source}: no variation meets the constraints.")
    step = max(1, count // _TRIED)
    chosen = list(islice(variations, 0, None, step))[:_TRIED]
    refused, began = "", time.perf_counter()
    for number, variation in enumerate(chosen):
        progress("try", number, len(chosen))
        row = row_of(sweep, variation)
        refused = refused or row["message"]
    return Estimate(count, _workers(jobs), len(chosen), time.perf_counter() - began, refused)


def _workers(jobs: int | None) -> int:
    if jobs is not None:
        return jobs
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _begun(sweep: Sweep, source: str) -> Variations:
    """The variations; an axis that is no key of the job is refused before anything is made."""
    variations = variations_of(sweep, source)
    for variation in islice(variations, 1):
        job = sweep.job(variation.values)
        if Measure.SHEETS in sweep.measure and job.cutter is None:
            raise InvalidJob(
                f"{source}: measure = ['sheets'] needs a table [cutter] in the base job, or axes "
                "such as cutter.material and cutter.machine."
            )
    return variations


def run_sweep(
    sweep: Sweep,
    folder: str | Path,
    *,
    jobs: int | None = None,
    cluster: ClusterSettings | None = None,
    source: str = "sweep",
    progress: Progress = silent,
) -> SweepResult:
    """Run all variations of a sweep that are not in the folder yet, and write its table.

    Parameters
    ----------
    jobs : how many processes work; one for each processor where left out.
    cluster : what works in place of them.
    source : what messages call the sweep.

    Raises `InvalidJob` for what is wrong with the sweep, the folder or the cluster. Whatever ends
    it, rows that are done are kept, and the next run goes on from there.
    """
    require_parent()
    path, variations = Path(folder), _begun(sweep, source)
    if cluster is None:
        workers = _workers(jobs)
        pool = Pool(partial(local_pool, workers, sweep.limits), workers)
    else:
        pool = Pool(partial(cluster_pool, cluster), cluster.workers, lost_batches())
    with locked(path):
        there = SweepFolder(path, sweep, variations)
        step = partial(progress, "sweep")
        result = _searched if sweep.search is not None else _swept
        try:
            return result(there, variations, pool, step, source)
        except (CancelledError, OSError) as error:
            if cluster is None:
                raise
            raise InvalidJob(
                f"the cluster is gone: {error or 'its scheduler does not answer'}. Rows that are "
                "done are kept: start it again, or leave it out, and run this again to go on."
            ) from error


def sweep(
    job: Job,
    axes: Mapping[str, Any],
    folder: str | Path,
    *,
    settings: Mapping[str, Any] | None = None,
    jobs: int | None = None,
    cluster: ClusterSettings | None = None,
    progress: Progress = silent,
) -> SweepResult:
    """Run a job with all combinations of the values of some keys, or search them for the best.

    Parameters
    ----------
    axes : values by dotted keys, such as {"design.fold_deg": [30.0, 60.0]}; steps and random values
        as in a sweep file.
    folder : where the table and its parts are written; what is there is not run again.
    settings : other keys of a sweep file, such as {"measure": ["fold"]} or a table "search".
    jobs, cluster, progress : as in `run_sweep`.

    Worker processes import the script that calls this, so that it has to be called under
    `if __name__ == "__main__":`. Raises `InvalidJob` as `run_sweep`.
    """
    document = plain({**(settings or {}), "axes": dict(axes)})
    found = sweep_of(job, document)
    return run_sweep(found, folder, jobs=jobs, cluster=cluster, progress=progress)


def _swept(
    there: SweepFolder, variations: Variations, pool: Pool, step: Steps, source: str
) -> SweepResult:
    """Every variation, run where it has no row yet."""
    del variations
    there.require_parts()
    again = there.drop_unsettled()
    plan = there.begin()
    if not plan.variations:
        raise InvalidJob(f"{source}: no variation meets the constraints.")
    pending = there.pending(plan.hashes)

    def batch_of(size: int) -> Batch | None:
        chosen = tuple(islice(pending, size))
        return Batch(there.sweep, chosen, there.files) if chosen else None

    if plan.hashes:
        run_batches(batch_of, len(plan.hashes), pool, there.keep, step)
    made = _result(there, plan, plan.jobs - len(plan.hashes))
    return replace(made, again=again)


def _searched(
    there: SweepFolder, variations: Variations, pool: Pool, step: Steps, source: str
) -> SweepResult:
    """The variations that a search proposes, and a job of each that is best."""
    del source
    there.require_parts()
    search = Search(there.sweep, variations.axes, there.path)
    before = search.run(there, pool, step)
    there = replace(there, variations=Listed(variations.axes, tuple(search.variations())))
    plan = there.begin()
    made = _result(there, plan, before)
    best = best_rows(there.rows(), search.goals)
    keys = [axis.key for axis in variations.axes]
    jobs = {
        f"best_{place}.toml" if len(best) > 1 else "best.toml": job_bytes(
            there.sweep.varied({key: row[key] for key in keys})
        )
        for place, row in enumerate(best[:_MOST_BEST], 1)
    }
    there.write_jobs(jobs)
    return replace(made, best=tuple(jobs))


def _result(there: SweepFolder, plan: Plan, begun_with: int) -> SweepResult:
    statuses = there.write_results()
    there.write_page()
    table = there.path / "results.parquet"
    found = (plan.variations, plan.jobs, begun_with, plan.others, plan.damaged)
    return SweepResult(table, *found, statuses)
