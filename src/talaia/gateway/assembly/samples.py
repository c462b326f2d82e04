"""From samples to batches: numbered, kept on disk until the hub has them, gaps recorded."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from talaia.clock import SECOND
from talaia.gateway.assembly.gateway_part import GatewayPart
from talaia.gateway.freeze_watchdog import watch_stalls
from talaia.gateway.legacy.messages import NewestValues
from talaia.gateway.samples.absence_gaps import (
    NOT_HEARD,
    NOT_RUNNING,
    absence_span,
    watch_first_heard,
)
from talaia.gateway.samples.batching import Batcher
from talaia.gateway.samples.derived_values import DerivedValues
from talaia.gateway.spool.journal import SegmentHead, Spool
from talaia.gateway.spool.progress_mark import machine_run
from talaia.gateway.spool.spool_thread import SpoolThread

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    from talaia.gateway.assembly.description import DescriptionPart
    from talaia.gateway.assembly.foundation import FoundationPart
    from talaia.gateway.reload.current_description import PreparedDescription
    from talaia.gateway.spool.segment import SampleRecord

__all__ = ["SamplesPart"]


class SamplesPart(GatewayPart):
    """Where adapters give what they hear.

    Attributes:
        spool: has what the hub has not, on disk.
        batcher: numbers samples.
        newest_values: for clients of the legacy API; none where that is not served.
        sink: takes samples, and adds what is worked out from them.

    """

    def __init__(self, *, base: FoundationPart, description: DescriptionPart) -> None:
        """Make the spool ready, with what an earlier run left in it.

        Raises:
            SpoolError: the data folder cannot be used.

        """
        self._base, self._numbering = base, description.numbering
        settings, clock, begun = base.settings, base.clock, description.current.now
        spool = Spool(
            folder=settings.data / "spool",
            head=SegmentHead(base.boot, begun.catalogue, begun.addresses),
            bound=settings.spool_bytes,
            age_s=settings.spool_age_s,
            spare=settings.spare_bytes,
            # In seconds, and monotonic: nothing in the spool grows old by a clock that is set.
            now=lambda: clock.monotonic_ns() / SECOND,
            wall_us=base.wall_us,
            machine=machine_run(),
        )
        self.spool = SpoolThread(spool, gather_s=settings.flush)
        self.batcher = Batcher(
            loop=base.loop,
            boot=base.boot,
            catalogue=begun.catalogue,
            flush=settings.flush,
            keep=self._keep_batch,
            lose=self.spool.record_loss,
        )
        # Before the first sample, so that the gap has the lower number.
        self._record_absence()
        self.newest_values: NewestValues | None = None
        numbers = description.numbering.numbers_of(description.site)
        if settings.door is not None:
            self.newest_values = NewestValues(numbers, self.batcher, clock.monotonic_ns)
        # Where founding clients are served they see each sample on its way to the batcher.
        self.sink = DerivedValues(
            site=description.site,
            numbers=numbers,
            sink=self.newest_values or self.batcher,
            clock=clock,
            loop=base.loop,
        )

    def redescribe(self, prepared: PreparedDescription) -> None:
        """Number, keep and send samples by another list of channels from here on."""
        catalogue, addresses = prepared.catalogue, prepared.addresses
        # Samples before the spool: what still waits is flushed by the old list, into the old
        # segment.
        self.batcher.redescribe(catalogue, self._numbering.order_of(prepared.site))
        self.spool.redescribe(SegmentHead(self._base.boot, catalogue, addresses))
        numbers = self._numbering.numbers_of(prepared.site)
        if self.newest_values is not None:
            self.newest_values.redescribe(numbers)
        self.sink.redescribe(prepared.site, numbers)

    def _keep_batch(self, record: SampleRecord) -> None:
        # The link first, which only queues; the spool is on a thread of its own.
        self._base.lanes.live(record.body, record.first, record.end)
        self.spool.append_record(record)

    def _record_absence(self) -> None:
        """Record the time since the run before heard anything as a gap, if there was one."""
        former = self.spool.former
        if former is None:
            # Nobody missed anything before the first run.
            self.batcher.first_heard.end_watching()
        else:
            mono_s = self._base.clock.monotonic_ns() / SECOND
            span = absence_span(former, self._base.wall_us(), mono_s, machine_run())
            self.batcher.record_gap(*span, NOT_RUNNING)
            if 0 < former.deaf_us <= former.heard_us:
                # It ended before it could tell since when it heard all.
                self.batcher.record_gap(former.deaf_us, former.heard_us, NOT_HEARD)

    def tasks(self) -> Mapping[str, Callable[[], Awaitable[None]]]:
        """Force samples to disk, and notice times in which nothing was heard."""
        base, batcher = self._base, self.batcher
        tasks: dict[str, Callable[[], Awaitable[None]]] = {
            "sync": partial(self.spool.keep_syncing, base.settings.sync, base.wall_us),
            "freezes": partial(watch_stalls, base.clock, batcher.record_gap),
        }
        # After another run only, see `_record_absence`.
        if self.spool.former is not None:
            tasks["first heard"] = partial(
                watch_first_heard,
                batcher.first_heard,
                base.clock,
                batcher.record_gap,
                self.spool.all_heard,
            )
        return tasks

    async def close(self) -> None:
        """Have on disk what was heard to the end."""
        self.sink.close()
        # First: what waits in the batcher goes into the spool before that is closed.
        self.batcher.flush_batches()
        await self.spool.close()
