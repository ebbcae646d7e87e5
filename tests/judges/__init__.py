"""Other people's importers, each run in a process of its own; all print the table that `read_table` reads.

* `ecos`: the native engine of Ecos, from the wheel `ecospy`;
* `libcosim`: the native engine of the Open Simulation Platform, from the wheel `libcosimpy`;
* `ssp`: the two engines, reading systems from .ssp files;
* `rust_fmi`: the crate `fmi` of rust-fmi, by way of the program in `tests/judges/rust-fmi`.
"""

from __future__ import annotations

import csv
import io

import numpy as np

from ..support.harness import Result


def read_table(text: str) -> Result:
    """A CSV table with a header and a column `time`; numbers are exact decimals."""
    header, *rows = csv.reader(io.StringIO(text))
    columns = dict(zip(header, np.array(rows, dtype=float).T))
    return Result(columns.pop("time"), columns)


def different(theirs: Result, ours: Result) -> list[str]:
    """Signals that are not equal to the bit."""
    return [name for name in ours.signals if not np.array_equal(theirs[name], ours[name])]
