"""Search for the best variations: Optuna proposes them, by what became of those before.

The trials are kept in a journal beside the parts, so that a search that was ended goes on. Rows are
those of any sweep, in the same parts and table.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from fab.errors import InvalidJob
from fab.progress import Steps
from fab.sweeps.axes import Axis
from fab.sweeps.columns import FIGURES
from fab.sweeps.constraints import Constraint, constraints_of
from fab.sweeps.dotted_names import named
from fab.sweeps.engine import Pool, run_batches
from fab.sweeps.pareto import pareto_front
from fab.sweeps.parts import unwritten
from fab.sweeps.rows import Batch
from fab.sweeps.search_settings import SearchSettings
from fab.sweeps.sweep_folder import SweepFolder
from fab.sweeps.sweep_settings import Sweep
from fab.sweeps.variations import Variation

__all__ = ["Goals", "Search", "best_rows"]

_JOURNAL = "search.journal"
# What is noted of a study: trials that ended with their run; and of a trial: by how much it misses
# each condition.
_COLUMN = "column of numbers in the table"
_ENDED = "ended"
_EXCESS = "excess"


@dataclass(frozen=True)
class Goals:
    """The goals and conditions of a search by the names of their columns."""

    columns: tuple[str, ...]
    signs: tuple[int, ...]
    conditions: tuple[Constraint, ...]

    @classmethod
    def of(cls, search: SearchSettings) -> Goals:
        """Raises `InvalidJob` for columns that are not there, or no numbers."""
        numbers = [column.name for column in FIGURES if column.kind in ("whole", "number")]
        names = tuple(named(name, numbers, _COLUMN) for name in search.goals)
        return cls(names, tuple(search.signs), constraints_of(search.conditions, numbers, _COLUMN))

    @property
    def needed(self) -> tuple[str, ...]:
        """The columns of goals and conditions."""
        return (*self.columns, *(key for each in self.conditions for key in each.keys))

    def values(self, row: Mapping[str, Any]) -> list[float] | None:
        """What is to be low of a row; None where it has no such figures."""
        figures = [row.get(column) for column in self.columns]
        if row["status"] != "made" or any(figure is None for figure in figures):
            return None
        return [sign * float(x) for sign, x in zip(self.signs, figures, strict=True)]  # type: ignore[arg-type]

    def excess(self, row: Mapping[str, Any]) -> list[float]:
        """By how much each condition is missed, 0 or less where it holds."""
        return [condition.excess(row) for condition in self.conditions]


class Search:
    """The trials of a sweep in a folder, of this run and those before."""

    def __init__(self, sweep: Sweep, axes: Sequence[Axis], folder: Path) -> None:
        self.optuna = _optuna()
        if sweep.search is None:
            raise InvalidJob("the sweep has no table [search].")
        self.sweep, self.axes, self.settings = sweep, tuple(axes), sweep.search
        self.goals = Goals.of(self.settings)
        sweep.require_measured(self.goals.needed)
        self._between = constraints_of(sweep.constraints, [axis.key for axis in axes])
        self._journal = folder / _JOURNAL
        with self._whole():
            self.study = self._study()
            if len(self.study.directions) != len(self.goals.columns):
                raise ValueError("a study of the same name has other goals")
            self._take_up_ended()
            self._count()

    @contextmanager
    def _whole(self) -> Iterator[None]:
        """The journal is read. Raises `InvalidJob` where it is damaged, or cannot be written."""
        try:
            _drop_begun_line(self._journal)
            yield
        except OSError as error:
            raise unwritten(self._journal, error) from error
        except Exception as error:  # Optuna raises whatever damaged lines lead to
            raise InvalidJob(
                f"{self._journal}: is damaged. Delete it: the search begins anew, and takes the "
                "rows that are there."
            ) from error

    def _study(self) -> Any:
        from optuna.storages import JournalStorage
        from optuna.storages.journal import JournalFileBackend

        self.optuna.logging.set_verbosity(self.optuna.logging.ERROR)
        # another space, or other goals, are another study in the same journal
        space = [(axis.key, axis.drawn or axis.values) for axis in self.axes]
        name = repr((space, self.goals.columns, self.goals.signs, self.settings.conditions))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of features that Optuna calls experimental
            return self.optuna.create_study(
                storage=JournalStorage(JournalFileBackend(str(self._journal))),
                study_name=name,
                sampler=self.optuna.samplers.TPESampler(
                    seed=self.settings.seed,
                    multivariate=True,
                    constant_liar=True,
                    constraints_func=_excess_of if self.goals.conditions else None,
                ),
                directions=["minimize"] * len(self.goals.columns),
                load_if_exists=True,
            )

    def run(self, there: SweepFolder, pool: Pool, progress: Steps) -> int:
        """Run the trials that are left, and keep their rows. How many there were before."""
        rows = there.parts.rows(["status", *self.goals.needed])
        before = begun = self._count()
        asked: dict[str, list[Any]] = {}

        def batch_of(size: int) -> Batch | None:
            nonlocal begun
            chosen: list[Variation] = []
            while begun < self.settings.trials and len(chosen) < size:
                trial = self._asked()
                begun += 1
                variation = self._variation(trial)
                hashed = there.hash_of(variation)
                if not self._meets(variation):
                    self._tell(trial, None)
                elif hashed in rows:
                    self._tell(trial, rows[hashed])
                elif hashed in asked:
                    asked[hashed].append(trial)
                else:
                    asked[hashed] = [trial]
                    chosen.append(replace(variation, job_hash=hashed))
            return Batch(self.sweep, tuple(chosen), there.files) if chosen else None

        def keep(found: list[dict[str, Any]]) -> None:
            there.keep(found)
            for row in found:
                rows[row["job_hash"]] = row
                for trial in asked.pop(row["job_hash"], []):
                    self._tell(trial, row)

        if begun < self.settings.trials:
            # one at a time and none waiting: each is asked for with all that is known
            left = self.settings.trials - before
            run_batches(batch_of, left, pool, keep, progress, most=1, ahead=1)
        return before

    def _take_up_ended(self) -> None:
        """Trials that a run was at when it was ended are asked for again."""
        running = self.optuna.trial.TrialState.RUNNING
        ended = list(self.study.user_attrs.get(_ENDED, []))
        for trial in self.study.get_trials(deepcopy=False, states=(running,)):
            self.study.tell(trial.number, state=self.optuna.trial.TrialState.FAIL)
            ended.append(trial.number)
            if len(trial.params) == len(self.axes):
                self.study.enqueue_trial(trial.params)
        self.study.set_user_attr(_ENDED, ended)

    def _count(self) -> int:
        """How many trials were asked for and not ended."""
        waiting = self.optuna.trial.TrialState.WAITING
        trials = [t for t in self.study.get_trials(deepcopy=False) if t.state != waiting]
        return len(trials) - len(self.study.user_attrs[_ENDED])

    def variations(self) -> Iterator[Variation]:
        """Those of all trials that were run, in the order of the trials."""
        ended = set(self.study.user_attrs.get(_ENDED, []))
        for trial in self.study.get_trials(deepcopy=False):
            variation = self._variation(trial)
            whole = trial.number not in ended and len(variation.values) == len(self.axes)
            if whole and self._meets(variation):
                yield variation

    def _meets(self, variation: Variation) -> bool:
        return all(constraint.holds(variation.values) for constraint in self._between)

    def _asked(self) -> Any:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # as above
            trial = self.study.ask()
            for axis in self.axes:
                if axis.drawn is None:
                    trial.suggest_categorical(axis.key, axis.values)
                elif all(isinstance(value, int) for value in axis.values):
                    trial.suggest_int(axis.key, *map(int, axis.drawn))
                else:
                    trial.suggest_float(axis.key, *axis.drawn)
        return trial

    def _variation(self, trial: Any) -> Variation:
        values = {
            axis.key: trial.params[axis.key] for axis in self.axes if axis.key in trial.params
        }
        return Variation(trial.number, values)

    def _tell(self, trial: Any, row: Mapping[str, Any] | None) -> None:
        """What became of a trial; one that was not made is worse than all that were."""
        states = self.optuna.trial.TrialState
        values = None if row is None else self.goals.values(row)
        if row is None or values is None:
            alone = len(self.goals.columns) == 1
            self.study.tell(trial, state=states.PRUNED if alone else states.FAIL)
            return
        trial.set_user_attr(_EXCESS, self.goals.excess(row))
        self.study.tell(trial, values)


def _drop_begun_line(journal: Path) -> None:
    """Cut off the last line where a run was killed that wrote it: others would follow it there."""
    if not journal.is_file():
        return
    with journal.open("r+b") as stream:
        data = stream.read()
        stream.truncate(data.rfind(b"\n") + 1)


def _excess_of(trial: Any) -> Sequence[float]:
    found: Sequence[float] = trial.user_attrs.get(_EXCESS, (1.0,))
    return found


def best_rows(rows: Sequence[Mapping[str, Any]], goals: Goals) -> list[Mapping[str, Any]]:
    """Rows that meet all conditions and are best: one, or the Pareto front of several goals.

    Sorted by the first goal. Of equal ones the first is taken.
    """
    fit = [
        (values, row)
        for row in rows
        if (values := goals.values(row)) is not None and max(goals.excess(row), default=0.0) <= 0
    ]
    if not fit:
        return []
    front = pareto_front(np.array([values for values, _ in fit]))
    chosen: dict[tuple[float, ...], Mapping[str, Any]] = {}
    for (values, row), is_best in zip(fit, front, strict=True):
        if is_best:
            chosen.setdefault(tuple(values), row)
    return [chosen[values] for values in sorted(chosen)]


def _optuna() -> Any:
    try:
        import optuna
    except ImportError as error:
        raise InvalidJob(
            "a search needs Optuna, which is not installed. pip install 'quadfold[search]' brings "
            "it; a sweep without [search] runs as it is."
        ) from error
    return optuna
