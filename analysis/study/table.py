"""The study's results as a table: Parquet, a row per cell, channel, estimator and parameter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from foundation.output import new_file

Rows = Sequence[Mapping[str, Any]]

COLUMNS: Mapping[str, str] = {
    "place": "string",
    "lamp": "string",
    "bits": "int64",
    "electrons_per_dn8": "double",
    "noise_steps": "double",
    "blur_px": "double",
    "channel": "string",
    "level_dn8": "double",
    "rise_dn8": "double",
    "rise_steps": "double",
    "ramp_variance_steps2": "double",
    "method": "string",
    "parameter": "string",
    "unit": "string",
    "truth": "double",
    "estimate": "double",
    "bias": "double",
    "bias_se": "double",
    "scatter": "double",
    "answered": "double",
    "predicted_bias": "double",
}
"""Names and types; estimates are null where no body gave one, predictions where there is no closed
form. Figures are in DN of the cell's own bits, but for those whose name says DN8."""


def write_parquet(path: Path, rows: Rows) -> None:
    """Write the rows whole or not at all."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    schema = pa.schema([(name, pa.type_for_alias(kind)) for name, kind in COLUMNS.items()])
    with new_file(path) as scratch:
        pq.write_table(pa.Table.from_pylist(list(rows), schema=schema), scratch)


def read_parquet(path: Path) -> list[dict[str, Any]]:
    """The rows of a file that `write_parquet` made."""
    import pyarrow.parquet as pq

    rows: list[dict[str, Any]] = pq.read_table(path).to_pylist()
    return rows
