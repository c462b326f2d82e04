"""What the writing thread is asked to do."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from talaia.hub.history.errors import HistoryError
from talaia.wire.columns import Columns

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from talaia.hub.history.writing.retention import Doomed
    from talaia.model.site import Site

__all__ = [
    "Adopt",
    "AdoptRuns",
    "Append",
    "ArrivingChannel",
    "Below",
    "Describe",
    "Drop",
    "Forget",
    "GapJob",
    "Job",
    "ReadRuns",
    "Rename",
    "SealSite",
    "Show",
    "checked_columns",
]


class Append(NamedTuple):
    """Store a batch; sample i has the sequence number ``first + i``."""

    site: str
    boot: str
    first: int
    addresses: Sequence[str]
    columns: Columns


class GapJob(NamedTuple):
    """Store that ``first`` to ``last`` of a boot are lost."""

    site: str
    boot: str
    first: int
    last: int
    from_us: int
    to_us: int
    reason: str


class Below(NamedTuple):
    """Ask up to where a boot is stored without a hole."""

    site: str
    boot: str


class Describe(NamedTuple):
    """Give numbers to channels that may have no sample yet."""

    site: str
    addresses: Sequence[str]

    @classmethod
    def every_channel(cls, site: Site) -> Describe:
        """Name all that a description has."""
        return cls(site.site, [channel.address for channel in site.channels()])


class Rename(NamedTuple):
    """Let channels go on under other addresses; ``moves`` has them by their former ones."""

    site: str
    moves: Mapping[str, str]


class Show(NamedTuple):
    """Write the newest reading of each channel as a plain row."""


class Drop(NamedTuple):
    """Delete blocks."""

    doomed: Sequence[Doomed]


class SealSite(NamedTuple):
    """Make blocks of all that a site has outside of them; answers how many channels still have.

    It is asked again until that is none; samples that come meanwhile are sealed, too.
    """

    site: str


class ReadRuns(NamedTuple):
    """Ask what of each boot of a site is stored; ``found`` is filled in by the writing thread."""

    site: str
    found: dict[str, list[tuple[int, int]]]


class ArrivingChannel(NamedTuple):
    """A channel of a site that comes from another server.

    Attributes:
        source: its number there.
        since_us: since when it has been known (µs, UTC).
        block: its last block that has come, with those of the same job, by the number there.

    """

    source: int
    address: str
    since_us: int
    block: int


class Adopt(NamedTuple):
    """Store what comes from another server; rows have the channels' numbers of there.

    Attributes:
        move: tells this move from any other.
        blocks: rows of blocks, each with its body.
        rollups: rows in place of those that came before.
        recent: readings that views show.

    """

    site: str
    move: str
    channels: Sequence[ArrivingChannel]
    blocks: Sequence[tuple[dict[str, Any], bytes]] = ()
    rollups: Sequence[dict[str, Any]] = ()
    recent: Sequence[dict[str, Any]] = ()


class AdoptRuns(NamedTuple):
    """Count as stored what was on another server."""

    site: str
    runs: Mapping[str, Sequence[tuple[int, int]]]


class Forget(NamedTuple):
    """Delete the rest of a site: channels, boots, and what of it is in the journal."""

    site: str


Job = (
    Append
    | GapJob
    | Below
    | Describe
    | Rename
    | Show
    | Drop
    | SealSite
    | ReadRuns
    | Adopt
    | AdoptRuns
    | Forget
)


def checked_columns(job: Append) -> Columns:
    """Give a batch's columns in the types they are stored in.

    Raises:
        HistoryError: they do not fit together.

    """
    columns = job.columns
    count = columns.channel.size
    problem = ""
    if job.first < 0 or job.first + count > 2**63 - 1:
        problem = f"its first sequence number is {job.first}"
    elif columns.time_us.size != count or columns.value.size != count:
        problem = f"its columns have {count}, {columns.time_us.size} and {columns.value.size} rows"
    elif count and int(columns.channel.max()) >= len(job.addresses):
        problem = f"it names channel {columns.channel.max()} of {len(job.addresses)}"
    elif any(not 0 <= position < count for position in columns.texts):
        problem = "a text stands outside of it"
    if problem:
        raise HistoryError(f"a batch from {job.site} cannot be stored: {problem}")
    return Columns(
        columns.channel,
        columns.time_us.astype(np.int64, copy=False),
        columns.value.astype(np.float64, copy=False),
        columns.texts,
    )
