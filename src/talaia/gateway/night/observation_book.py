"""Numbers what became of observations, and knows what the hub has not acknowledged. Pure.

What is in it is on disk: a gateway whose hub is away all night tells it in the morning, and one
that is started anew goes on with the frames that there are. With thousands that a hub has not heard
of the whole book is long: what is new is written behind it as entries, and all of it only once the
entries are as many again, so that each change costs the same however many there were before.
"""

from __future__ import annotations

from bisect import bisect_right
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.gateway.night.night_values import ObservationChange
from talaia.gateway.night.planning.charged_time import TimeCharge, add_charge, charged_seconds
from talaia.model.observing.states import (
    FINAL_OBSERVATION_STATES,
    ObservationState,
    SuspensionCause,
)
from talaia.wire.frames import ObservationUpdate

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from talaia.model.observing.requests import RequestGroup

__all__ = ["BookContent", "BookEntry", "BookPages", "ObservationBook", "OpenObservation"]

# With more than this unacknowledged, steps between the states of one try are left out.
MOST_WAITING = 500
# So many entries stand behind the whole book before it is written anew.
MOST_ENTRIES = 200
_O = ObservationState


class OpenObservation(msgspec.Struct, frozen=True, kw_only=True):
    """A try at a request that may go on.

    Attributes:
        id: unique at this gateway.
        state: where it stands.
        frames_done: of each configuration.
        block_s: charged before the visit that is under way (s).
        told_s: charged with it, as was told last (s).
        proposal: who pays.

    """

    id: str
    state: ObservationState = _O.IN_PROGRESS
    frames_done: tuple[int, ...] = ()
    block_s: float = 0.0
    told_s: float = 0.0
    proposal: str = ""


class BookContent(msgspec.Struct, kw_only=True):
    """What is kept on disk.

    Attributes:
        number: of the newest update; 0: none yet.
        made: so many observations have been begun.
        open: by request.
        ended: requests that were completed here, with the update that says so.
        waiting: what the hub has not acknowledged.
        acked: the newest update that it has.
        charges: block time that is not in the hours of the newest set of requests.

    """

    number: int = 0
    made: int = 0
    open: dict[str, OpenObservation] = {}
    ended: dict[str, int] = {}
    waiting: list[ObservationUpdate] = []
    acked: int = 0
    charges: list[TimeCharge] = []


class BookEntry(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """One change of the book.

    Attributes:
        made: so many observations have been begun.
        update: what is to be told; none: the hub has acknowledged something.
        open: the try of its request as it stands behind it; none: it has ended.
        charge: what it charges; none: nothing.
        acked: the newest update that the hub has.

    """

    made: int = 0
    update: ObservationUpdate | None = None
    open: OpenObservation | None = None
    charge: TimeCharge | None = None
    acked: int = 0


class BookPages(NamedTuple):
    """What is to be written now.

    Attributes:
        whole: the book, in the place of all before; none: what stands there goes on.
        entries: behind it.

    """

    whole: BookContent | None
    entries: tuple[BookEntry, ...]


class ObservationBook:
    """See the module.

    Attributes:
        content: what is to be kept on disk.

    """

    def __init__(
        self, content: BookContent, gateway: str, entries: Iterable[BookEntry] = ()
    ) -> None:
        """Go on with what an earlier run left; ``gateway`` is part of the ids."""
        self.content = content
        self._gateway = gateway
        # What each proposal was charged, summed up.
        self._charged = charged_seconds(content.charges)
        # Steps are left out once so many wait.
        self._crowded = MOST_WAITING
        # What is not written yet, and how many entries stand behind the whole book; none: it is
        # to be written whole.
        self._fresh: list[BookEntry] = []
        self._behind: int | None = None
        for entry in entries:
            self._apply_entry(entry)

    def close_interrupted(self, time: float) -> list[ObservationUpdate]:
        """Suspend what an earlier run had under way; give what is to be told."""
        under_way = [
            (request, one)
            for request, one in self.content.open.items()
            if one.state is _O.IN_PROGRESS
        ]
        return [
            self.record_change(
                ObservationChange(
                    request,
                    _O.SUSPENDED,
                    one.frames_done,
                    SuspensionCause.FAULT,
                    "the gateway was started anew",
                    # As far as is known: until it was told last.
                    max(0.0, one.told_s - one.block_s),
                ),
                time,
            )
            for request, one in under_way
        ]

    def record_change(
        self,
        change: ObservationChange,
        time: float,
        files: Sequence[str] = (),
        payers: Mapping[str, str] | None = None,
    ) -> ObservationUpdate:
        """Number a change, with the files since the last one; give what is to be told.

        Args:
            change: what happened.
            time: s since the epoch (UTC).
            files: digests of files since the last change.
            payers: who pays for each request; who paid for the try before goes on to.

        """
        proposal = (payers or {}).get(change.request, "")
        book, made = self.content, self.content.made
        before = book.open.get(change.request)
        if before is None:
            made += 1
            before = OpenObservation(id=f"{self._gateway}-{made:06d}", proposal=proposal)
        spent = before.block_s + change.block_s
        update = ObservationUpdate(
            number=book.number + 1,
            id=before.id,
            request=change.request,
            state=change.state,
            cause=change.cause,
            why=change.why,
            time=max(0.0, time),
            frames_done=list(change.frames_done[:100]),
            block_s=spent,
            files=list(files),
        )
        charge = TimeCharge(
            number=update.number,
            proposal=before.proposal or proposal,
            seconds=spent - before.told_s,
        )
        entry = BookEntry(
            made=made,
            update=update,
            open=_still_open(change, before, spent),
            # What charges nobody, or nothing, is left out.
            charge=charge if charge.seconds > 0.0 and charge.proposal else None,
        )
        self._apply_entry(entry)
        self._fresh.append(entry)
        return update

    def _apply_entry(self, entry: BookEntry) -> None:
        book, update = self.content, entry.update
        if update is None:
            self._forget_until(entry.acked)
            return
        book.number, book.made = update.number, entry.made
        if entry.charge is not None:
            add_charge(book.charges, entry.charge)
            proposal = entry.charge.proposal
            self._charged[proposal] = self._charged.get(proposal, 0.0) + entry.charge.seconds
        if update.state is _O.COMPLETED:
            book.ended[update.request] = update.number
        if entry.open is None:
            book.open.pop(update.request, None)
        else:
            book.open[update.request] = entry.open
        book.waiting.append(update)
        if len(book.waiting) > self._crowded:
            self._leave_out_steps()

    def take_pages(self) -> BookPages:
        """Give what is to be written now; it counts as written unless `write_whole` says not."""
        entries, self._fresh = tuple(self._fresh), []
        behind = self._behind
        # As many again as wait: each update is written in a whole book a few times, not each time.
        most = max(MOST_ENTRIES, len(self.content.waiting))
        if behind is None or behind + len(entries) > most:
            self._behind = 0
            return BookPages(self.content, ())
        self._behind = behind + len(entries)
        return BookPages(None, entries)

    def write_whole(self) -> None:
        """Write all of it next time: the disk did not take something, or it is another book."""
        self._behind = None

    def _leave_out_steps(self) -> None:
        """Keep of each try's steps in progress the last one: it says what those before said."""
        waiting = self.content.waiting
        last = {update.id: update.number for update in waiting}
        files: dict[str, list[str]] = {}
        kept = []
        for update in waiting:
            names = files.setdefault(update.id, [])
            names += update.files
            if update.state is not _O.IN_PROGRESS or last[update.id] == update.number:
                # Names of files of the steps that are left out go on with the next one.
                kept.append(msgspec.structs.replace(update, files=names))
                files[update.id] = []
        self.content.waiting = kept
        # Ends are not left out: with many of them, not looked at anew for each one more.
        self._crowded = max(MOST_WAITING, 2 * len(kept))

    def acknowledge_updates(self, number: int) -> bool:
        """Forget what the hub has; tell whether there was any of it."""
        forgotten = self._forget_until(number)
        if forgotten:
            self._fresh.append(BookEntry(acked=number))
        return forgotten

    def _forget_until(self, number: int) -> bool:
        self.content.acked = max(self.content.acked, number)
        # Their numbers rise.
        count = bisect_right(self.content.waiting, number, key=lambda one: one.number)
        del self.content.waiting[:count]
        self._crowded = min(self._crowded, max(MOST_WAITING, 2 * len(self.content.waiting)))
        return count > 0

    def settle_requests(self, groups: Iterable[RequestGroup]) -> None:
        """Take what is asked anew: what the hub knows to be done and asks again is done again."""
        asked = {request.id for group in groups for request in group.requests}
        waiting = {update.number for update in self.content.waiting}
        # One whose end the hub does not know yet is not begun a second time.
        self.content.ended = {
            request: number
            for request, number in self.content.ended.items()
            if number in waiting or (request in asked and number > self.content.acked)
        }
        # The hours that came with it have what the hub has acknowledged.
        self.content.charges = [
            one for one in self.content.charges if one.number > self.content.acked
        ]
        self._charged = charged_seconds(self.content.charges)
        self.write_whole()

    def charged_seconds(self) -> dict[str, float]:
        """Give what each proposal was charged here beyond the hours that the hub told (s)."""
        return dict(self._charged)

    def frames_done(self, groups: Sequence[RequestGroup]) -> dict[str, tuple[int, ...]]:
        """Give what there is of each request: as the hub says, or more by this gateway."""
        found: dict[str, tuple[int, ...]] = {}
        for group in groups:
            for request in group.requests:
                here = self.content.open.get(request.id)
                told = request.frames_done
                if here is not None and sum(here.frames_done) > sum(told):
                    told = here.frames_done
                if told:
                    found[request.id] = told
        return found

    @property
    def ended(self) -> frozenset[str]:
        """Requests that are done here, of which the hub may not know yet."""
        return frozenset(self.content.ended)


def _still_open(
    change: ObservationChange, before: OpenObservation, spent: float
) -> OpenObservation | None:
    """Give the try behind a change; none: it has ended."""
    if change.state in FINAL_OBSERVATION_STATES:
        return None
    # A visit that goes on counts its own time from its beginning.
    kept = spent if change.state is _O.SUSPENDED else before.block_s
    return msgspec.structs.replace(
        before,
        state=change.state,
        frames_done=change.frames_done,
        block_s=kept,
        told_s=max(spent, before.told_s),
    )
