"""A chart's answer as one Arrow stream: all its channels one below the other."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np
import pyarrow as pa

if TYPE_CHECKING:
    from talaia.hub.history.queries.series import Series

__all__ = ["METADATA_KEY", "series_to_arrow"]

# The schema's metadata under this key are JSON: for each channel how many rows, which kind, and
# its gaps, in the order of the rows.
METADATA_KEY = "talaia"


def series_to_arrow(found: list[Series]) -> bytes:
    """Write ``t_us`` (µs since the epoch), ``v`` and ``text`` of each series in turn."""
    time_us = np.concatenate([np.empty(0, np.int64), *(series.time_us for series in found)])
    value = np.concatenate([np.empty(0), *(series.value for series in found)])
    texts = [series.texts.get(at) for series in found for at in range(series.time_us.size)]
    about = {
        "series": [
            {
                "address": series.address,
                "kind": "exact" if series.exact else "minmax",
                "rows": int(series.time_us.size),
                "gaps": [gap._asdict() for gap in series.gaps],
            }
            for series in found
        ]
    }
    schema = pa.schema(
        [("t_us", pa.timestamp("us", "UTC")), ("v", pa.float64()), ("text", pa.string())],
        {METADATA_KEY: json.dumps(about)},
    )
    table = pa.table(
        [
            pa.array(time_us, pa.int64()).cast(pa.timestamp("us", "UTC")),
            pa.array(value, pa.float64()),
            pa.array(texts, pa.string()),
        ],
        schema=schema,
    )
    sink = pa.BufferOutputStream()
    with pa.ipc.new_stream(sink, schema) as writer:
        writer.write_table(table)
    body: bytes = sink.getvalue().to_pybytes()
    return body
