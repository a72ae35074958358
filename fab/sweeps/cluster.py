"""Clusters that work on a sweep: schedulers of Dask, by address or started for the run.

All of them give executors of `concurrent.futures`, as processes of this machine do, so that the
engine knows of none of them. Parts are written by the process that runs the sweep: workers need no
folder in common with it, unless files of variations are kept.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from typing import Any, Literal

from pydantic import Field, model_validator

from fab.errors import InvalidJob
from fab.settings import Settings

__all__ = ["ClusterSettings", "cluster_pool", "job_script", "lost_batches"]

_INSTALL = "pip install 'quadfold[cluster]' brings it."


class ClusterSettings(Settings):
    """The table `[cluster]` of a sweep: which scheduler, and what it is asked for."""

    kind: Literal["address", "local", "slurm", "pbs", "kubernetes"] = Field(
        description="a scheduler that runs already, processes of this machine, a batch system, or "
        "Kubernetes with its Dask operator"
    )
    address: str | None = Field(default=None, description="such as tcp://node1:8786")
    workers: int = Field(default=2, ge=1, le=10_000, description="processes with one thread each")
    memory_mb: int = Field(default=2048, ge=256, description="of each worker")
    queue: str | None = Field(default=None, description="or partition, of a batch system")
    account: str | None = Field(default=None, description="or project, of a batch system")
    walltime: str = Field(default="01:00:00", description="of a batch job, hh:mm:ss")
    prologue: list[str] = Field(
        default=[], description="lines of the job script before the worker, such as module load"
    )
    image: str | None = Field(default=None, description="of containers, with quadfold in it")

    @model_validator(mode="after")
    def _complete(self) -> ClusterSettings:
        for kind, key in (("address", "address"), ("kubernetes", "image")):
            if (self.kind == kind) and getattr(self, key) is None:
                raise ValueError(f"kind = {kind!r} needs {key}")
        return self


@contextmanager
def cluster_pool(settings: ClusterSettings) -> Iterator[Executor]:
    """An executor on the cluster. What was started for it ends with it.

    Raises `InvalidJob` where the library is not installed or the scheduler does not answer.
    """
    distributed = _library("distributed")
    cluster = None if settings.kind == "address" else _cluster(settings)
    try:
        client = distributed.Client(settings.address if cluster is None else cluster, timeout="10s")
    except (OSError, TimeoutError) as error:
        raise InvalidJob(
            f"cluster.address = {settings.address!r}: no scheduler answers there: {error}. Start "
            "one with `dask scheduler`, or leave the cluster out."
        ) from error
    try:
        client.wait_for_workers(1, timeout=_WORKERS_S)
        yield client.get_executor()
    except TimeoutError as error:
        raise InvalidJob(
            f"no worker of the cluster came within {_WORKERS_S} s. Start some with `dask worker`, "
            "or look at the queue. Rows that are done are kept."
        ) from error
    finally:
        client.close()
        if cluster is not None:
            cluster.close()


_WORKERS_S = 120


def lost_batches() -> tuple[type[BaseException], ...]:
    """Errors that mean: several workers died over this batch."""
    killed: type[BaseException] = _library("distributed").KilledWorker
    return (killed,)


def job_script(settings: ClusterSettings) -> str:
    """The script that a batch system is given for each worker. Raises `InvalidJob` for others."""
    if settings.kind not in ("slurm", "pbs"):
        raise InvalidJob(f"cluster.kind = {settings.kind!r} has no job script: slurm and pbs have.")
    jobqueue = _library("dask_jobqueue")
    job = jobqueue.slurm.SLURMJob if settings.kind == "slurm" else jobqueue.pbs.PBSJob
    return str(job(_SCHEDULER, name="quadfold", **_batch_keys(settings)).job_script())


# What stands for the address of the scheduler, which is known when the sweep runs.
_SCHEDULER = "tcp://SCHEDULER:8786"


def _batch_keys(settings: ClusterSettings) -> dict[str, Any]:
    """What a batch system is asked for, as dask-jobqueue names it."""
    return {
        "queue": settings.queue,
        "account": settings.account,
        "cores": 1,
        "processes": 1,
        "memory": f"{settings.memory_mb}MB",
        "walltime": settings.walltime,
        "job_script_prologue": settings.prologue,
    }


def _cluster(settings: ClusterSettings) -> Any:
    if settings.kind == "local":
        return _library("distributed").LocalCluster(
            n_workers=settings.workers,
            threads_per_worker=1,
            memory_limit=f"{settings.memory_mb}MB",
            dashboard_address=None,
        )
    if settings.kind == "kubernetes":
        operator = _library("dask_kubernetes.operator")
        return operator.KubeCluster(
            name="quadfold", image=settings.image, n_workers=settings.workers
        )
    jobqueue = _library("dask_jobqueue")
    system = jobqueue.SLURMCluster if settings.kind == "slurm" else jobqueue.PBSCluster
    cluster = system(**_batch_keys(settings))
    cluster.scale(settings.workers)
    return cluster


def _library(name: str) -> Any:
    from importlib import import_module

    try:
        return import_module(name)
    except ImportError as error:
        package = name.split(".")[0].replace("_", "-")
        raise InvalidJob(
            f"a cluster needs {package}, which is not installed. {_INSTALL}"
        ) from error
