"""Tables of sweeps as the tests compare them."""

from pathlib import Path
from typing import Any

import pyarrow.parquet as pq


def rows_of(folder: Path) -> list[dict[str, Any]]:
    """The rows of the table of a sweep, without their durations."""
    found: list[dict[str, Any]] = (
        pq.read_table(folder / "results.parquet").drop_columns(["seconds"]).to_pylist()
    )
    return found
