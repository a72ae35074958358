"""How much work folds in contact may take, counted so that it is the same on every machine."""

from __future__ import annotations

import math
from dataclasses import dataclass

__all__ = ["OutOfWorkError", "Work"]


class OutOfWorkError(Exception):
    """The work is spent. `fold_past_contact` turns it into a finding."""


@dataclass
class Work:
    """What is left of the work, in pairs of parts that are looked at.

    >>> work = Work(5.0)
    >>> work.spend(4)
    >>> work.spend(2)
    Traceback (most recent call last):
    fab.folding.contact.work.OutOfWorkError
    """

    left: float = math.inf

    def spend(self, pairs: float) -> None:
        """Count work. Raises `OutOfWorkError` where there is less left."""
        self.left -= pairs
        if self.left < 0:
            raise OutOfWorkError
