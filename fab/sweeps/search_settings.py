"""Settings of a search: what is to be lowest or highest, and the conditions that must hold."""

from __future__ import annotations

from pydantic import Field, model_validator

from fab.settings import Settings

__all__ = ["SearchSettings"]


class SearchSettings(Settings):
    """The table `[search]` of a sweep, whose axes are then the space that is searched."""

    minimise: list[str] = Field(default=[], max_length=5, description="columns of the table")
    maximise: list[str] = Field(default=[], max_length=5, description="columns of the table")
    conditions: list[str] = Field(
        default=[], max_length=20, description='such as "crossings <= 0", on columns of the table'
    )
    trials: int = Field(ge=1, le=100_000, description="variations in all, of earlier runs too")
    seed: int = Field(default=0, ge=0, description="of the search")

    @model_validator(mode="after")
    def _has_goals(self) -> SearchSettings:
        if not self.minimise and not self.maximise:
            raise ValueError("minimise and maximise are empty: name a column of the table")
        twice = set(self.minimise) & set(self.maximise)
        if twice:
            raise ValueError(f"{sorted(twice)[0]} is both in minimise and in maximise")
        return self

    @property
    def goals(self) -> list[str]:
        """The columns of all goals."""
        return [*self.minimise, *self.maximise]

    @property
    def signs(self) -> list[int]:
        """By which each goal is to be multiplied to be the lowest."""
        return [1] * len(self.minimise) + [-1] * len(self.maximise)
