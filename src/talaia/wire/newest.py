"""The newest sample of many channels, as the bytes of one message; see `frames.NewestBatch`.

Columns side by side, little-endian, as in `wire.columns`; but these samples are of any age and
from anywhere in their run, so that each has its own sequence number, time and age.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray  # noqa: TC002 - NamedTuple reads it at run time

from talaia.wire.columns import MAX_SAMPLES, Columns, slice_columns
from talaia.wire.errors import PeerError
from talaia.wire.frames import NewestBatch

__all__ = ["NewestSamples", "chosen_newest", "newest_frame", "newest_of", "runs_of"]

# The difference of two such numbers is still an i64.
_FARTHEST = 2**62


class NewestSamples(NamedTuple):
    """One sample a channel; the arrays have the shape (n,).

    Attributes:
        columns: the samples, in order of ``sequence``.
        sequence: their numbers in their run.
        age_ms: how long ago each was heard.

    """

    columns: Columns
    sequence: NDArray[np.int64]
    age_ms: NDArray[np.float64]


def newest_frame(
    known: NewestSamples, boot: str, catalogue: str, addresses: list[str] | None = None
) -> NewestBatch:
    """Make the message; ``addresses`` is what the channels index, where the catalogue is not."""
    columns = known.columns
    return NewestBatch(
        boot=boot,
        catalogue=catalogue,
        channel=columns.channel.astype("<u2").tobytes(),
        sequence=known.sequence.astype("<i8").tobytes(),
        time_us=columns.time_us.astype("<i8").tobytes(),
        value=columns.value.astype("<f8").tobytes(),
        age_ms=known.age_ms.astype("<f8").tobytes(),
        texts=columns.texts,
        addresses=addresses or [],
    )


def newest_of(message: NewestBatch) -> NewestSamples:
    """Read the message back.

    Raises:
        PeerError: the columns are not of one length, or hold what cannot be.

    """
    count = len(message.channel) // 2
    wide = (message.sequence, message.time_us, message.value, message.age_ms)
    if len(message.channel) != 2 * count or any(len(column) != 8 * count for column in wide):
        raise PeerError("newest samples in columns of unequal length")
    if count > MAX_SAMPLES or any(not 0 <= at < count for at in message.texts):
        raise PeerError("newest samples: too many, or a text outside of them")
    channel = np.frombuffer(message.channel, "<u2")
    sequence = np.frombuffer(message.sequence, "<i8")
    time_us = np.frombuffer(message.time_us, "<i8")
    age_ms = np.frombuffer(message.age_ms, "<f8")
    # Of no samples there is no least and no greatest.
    if count and (
        sequence.min() < 0
        or sequence.max() >= _FARTHEST
        # Not by `np.abs`: it leaves the least i64 negative.
        or time_us.min() <= -_FARTHEST
        or time_us.max() >= _FARTHEST
        # 10^15 ms are more than 30 000 years.
        or not (np.isfinite(age_ms) & (age_ms >= 0) & (age_ms < 1e15)).all()
        # `runs_of` cuts where numbers do not follow each other: they have to rise.
        or bool((np.diff(sequence) <= 0).any())
        # One sample a channel.
        or np.unique(channel).size != count
    ):
        raise PeerError("newest samples: a number, a time or an age that cannot be")
    columns = Columns(channel, time_us, np.frombuffer(message.value, "<f8"), message.texts)
    return NewestSamples(columns, sequence, age_ms)


def chosen_newest(known: NewestSamples, keep: NDArray[np.bool_]) -> NewestSamples:
    """Give those for which ``keep`` is true."""
    # Where each one that is kept stands afterwards.
    place = np.cumsum(keep) - 1
    texts = {int(place[at]): text for at, text in known.columns.texts.items() if keep[at]}
    columns = known.columns
    kept = Columns(columns.channel[keep], columns.time_us[keep], columns.value[keep], texts)
    return NewestSamples(kept, known.sequence[keep], known.age_ms[keep])


def runs_of(known: NewestSamples, below: int) -> list[tuple[int, Columns]]:
    """Cut them where their numbers do not follow each other; those under ``below`` are left out.

    Returns:
        The first number of each piece, and its samples.

    """
    known = chosen_newest(known, known.sequence >= below)
    count = len(known.columns)
    cuts = np.flatnonzero(np.diff(known.sequence) != 1) + 1
    # Of nothing there is one bound, and so no piece.
    bounds = [0, *cuts.tolist(), count] if count else [0]
    return [
        (int(known.sequence[begin]), slice_columns(known.columns, begin, end))
        for begin, end in pairwise(bounds)
    ]
