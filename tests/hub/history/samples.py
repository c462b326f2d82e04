"""Samples to store, and what is to be read back of them."""

import numpy as np

from talaia.wire.columns import Columns

ALL = (-(2**62), 2**62)


def batch(rows):
    """Make a batch of rows (channel, time, value or text)."""
    texts = {i: v for i, (_, _, v) in enumerate(rows) if isinstance(v, str)}
    return Columns(
        np.array([c for c, _, _ in rows], np.uint16),
        np.array([t for _, t, _ in rows], np.int64),
        np.array([np.nan if isinstance(v, str) else v for _, _, v in rows], np.float64),
        texts,
    )


def rows_of(series):
    """Give the series as (time, bits or text), sorted, so that two can be compared."""
    bits = series.value.view(np.uint64).tolist()
    return sorted(
        (t, series.texts.get(i, ""), 0 if i in series.texts else bits[i])
        for i, t in enumerate(series.time_us.tolist())
    )


def wanted(rows, channel):
    """Give what `rows_of` should say of a channel, for all these rows."""
    return sorted(
        (t, v, 0) if isinstance(v, str) else (t, "", int(np.float64(v).view(np.uint64)))
        for c, t, v in rows
        if c == channel
    )
