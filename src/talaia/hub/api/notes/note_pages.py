"""Notes of people: written, changed, removed, searched, and taken away as a file."""

from __future__ import annotations

import csv
import datetime as dt
import io
from typing import TYPE_CHECKING, Annotated

from fastapi import APIRouter, Query, Request
from fastapi.responses import StreamingResponse

from talaia.hub.api.access import address_of, live_of, number_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.notes.note_schemas import NoteAsk, NoteChangeAsk, NoteList, NoteShape
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.records.query_params import Time, Word  # noqa: TC001 - FastAPI reads it
from talaia.hub.auth.permissions import ANY, Right, sees_device
from talaia.hub.store.safe_text import safe_cell, safe_text
from talaia.hub.store.sites.notes import LONGEST_NOTE, MOST_NOTES, NoteBody, NoteFilter
from talaia.wire import browser

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from talaia.hub.auth.permissions import Who
    from talaia.hub.live.pages.page_connections import Browsers
    from talaia.hub.live.sites import LiveSite
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.sites.notes import KeptNote, NoteStore

__all__ = ["NotePages"]

_UNKNOWN = "there is no such note"
# Characters that are gathered before they are sent.
_CHUNK = 64 * 1024
_HEAD = ("from_utc", "to_utc", "device", "signal", "who", "text", "changed_utc", "changed_by")
# Pages show the beginning at once, and read the note for the rest.
_BEGINNING = 200


class NotePages:
    """The routes of notes."""

    def __init__(self, *, store: NoteStore, browsers: Browsers, audit: Audit) -> None:
        """Answer from ``store``; tell the pages of ``browsers`` that something has changed."""
        self._store = store
        self._browsers = browsers
        self._audit = audit

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        at = "/api/sites/{site}/notes"
        router.get(at)(self.find)
        router.post(at, status_code=201)(self.add)
        router.get(
            at + "/export",
            response_class=StreamingResponse,
            responses={200: {"content": {"text/csv": {"schema": {"type": "string"}}}}},
        )(self.export)
        router.put(at + "/{note}")(self.change)
        router.delete(at + "/{note}", status_code=204)(self.remove)
        return router

    async def find(
        self,
        *,
        request: Request,
        site: str,
        from_us: Time = 0,
        to_us: Time = 2**53,
        device: Word = "",
        who: Word = "",
        text: Word = "",
        before: Time | None = None,
        limit: Annotated[int, Query(ge=1, le=1000)] = 100,
    ) -> NoteList:
        """List the notes of which any part lies in a span, the last to begin first.

        Those about devices that you may view, as in the logbook. ``text``: each of its words
        stands somewhere in the note or its author's name. ``before`` is the id of the last one of
        a page, for the next page.
        """
        asker = who_of(request)
        wanted = NoteFilter(
            from_us=from_us,
            to_us=to_us,
            devices=asker.grants.devices(Right.VIEW, site),
            device=device,
            who=who,
            text=text,
            before=before,
        )
        found, more = await self._store.find_notes(site, wanted, limit)
        # A database may compare names without regard to case; a right does not.
        mine = [_note_shape(note, asker) for note in found if _may(asker, Right.VIEW, note)]
        return NoteList(notes=mine, more=more)

    async def add(self, asked: NoteAsk, request: Request) -> NoteShape:
        """Write a note. It takes the right to use its device, or the whole site."""
        live, asker = live_of(request), who_of(request)
        body = _body_of(asked)
        _require_use(asker, live, body)
        _require_known(live, body)
        kept = await self._store.add_note(live.name, body, asker.user, asker.name)
        if kept is None:
            problem = f"the site has {MOST_NOTES} notes; remove some first"
            raise ApiProblem(409, "busy", problem)
        self._announce_change(request, "note written", kept)
        return _note_shape(kept, asker)

    async def change(self, note: str, asked: NoteChangeAsk, request: Request) -> NoteShape:
        """Change a note: by its author, or an admin of what it is about."""
        live, asker = live_of(request), who_of(request)
        before = await self._find_changeable(note, request)
        body = _body_of(asked)
        # A note that is moved must not come to where its author may not write.
        _require_use(asker, live, body)
        if (body.device, body.signal) != (before.body.device, before.body.signal):
            _require_known(live, body)
        kept = await self._store.change_note(before, body, base=asked.base, who=asker.name)
        if kept is None:
            raise ApiProblem(409, "changed", "the note was changed meanwhile; load it anew")
        self._announce_change(request, "note changed", kept)
        return _note_shape(kept, asker)

    async def remove(self, note: str, request: Request) -> None:
        """Remove a note: by its author, or an admin of what it is about."""
        kept = await self._find_changeable(note, request)
        if not await self._store.remove_note(kept):
            raise ApiProblem(404, "unknown", _UNKNOWN)
        self._announce_change(request, "note removed", kept)

    async def export(
        self, *, request: Request, site: str, from_us: Time = 0, to_us: Time = 2**53
    ) -> StreamingResponse:
        """Give the notes of a span as a CSV file. Cells that look like formulas get a '."""
        asker = who_of(request)
        devices = asker.grants.devices(Right.VIEW, site)
        wanted = NoteFilter(from_us=from_us, to_us=to_us, devices=devices)
        rows = (
            note
            async for note in self._store.iterate_notes(site, wanted)
            if _may(asker, Right.VIEW, note)
        )
        name = f"{site}-notes-{from_us // 1_000_000}-{to_us // 1_000_000}.csv"
        return StreamingResponse(
            _write_csv(rows),
            media_type="text/csv; charset=utf-8",
            headers={"Content-Disposition": f'attachment; filename="{name}"'},
        )

    async def _find_changeable(self, note: str, request: Request) -> KeptNote:
        asker = who_of(request)
        kept = await self._store.find_note(live_of(request).name, number_of(note, "note"))
        # The same words whether it is hidden or not there at all.
        if kept is None or not _may(asker, Right.VIEW, kept):
            raise ApiProblem(404, "unknown", _UNKNOWN)
        if not _may_change(asker, kept):
            raise ApiProblem(403, "forbidden", "only its author or an admin changes a note")
        return kept

    def _announce_change(self, request: Request, kind: str, kept: KeptNote) -> None:
        """Write down what was done, with the words: a note that is gone can be read there."""
        asker, body = who_of(request), kept.body
        span = _utc(body.from_us) + (f" to {_utc(body.to_us)}" if body.to_us > body.from_us else "")
        about = f"{body.device}/{body.signal}" if body.signal else body.device or kept.site
        message = f"{about}, {span}: {body.text}"
        entry = self._audit.append_record(
            kind,
            who=asker.name,
            address=address_of(request),
            site=kept.site,
            device=body.device,
            message=message,
        )
        self._browsers.broadcast_message(
            browser.EventUpdate(
                site=kept.site,
                kind=kind,
                device=body.device,
                message=entry.message[:_BEGINNING],
                who=asker.name,
                time_us=entry.time_us,
                good=True,
            )
        )


def _body_of(asked: NoteAsk) -> NoteBody:
    """Give what is to be kept: lines stay, what is not seen is written as escapes."""
    lines = asked.text.strip().replace("\r\n", "\n").split("\n")
    text = "\n".join(safe_text(line, LONGEST_NOTE) for line in lines)[:LONGEST_NOTE]
    return NoteBody(asked.device, asked.signal, asked.from_us, asked.to_us, text)


def _require_use(asker: Who, live: LiveSite, body: NoteBody) -> None:
    """Refuse who may not write about it.

    Raises:
        ApiProblem: 403; 404 about a device that is hidden, as about one that is not there.

    """
    if not asker.grants.has_right(Right.USE, live.name, body.device or ANY):
        if body.device and not sees_device(asker.grants, live.description, body.device):
            raise ApiProblem(404, "unknown", "there is no such device")
        problem = "to write a note takes the right use on what it is about"
        raise ApiProblem(403, "forbidden", problem)


def _require_known(live: LiveSite, body: NoteBody) -> None:
    """Refuse what the site does not have.

    Raises:
        ApiProblem: 422.

    """
    device = live.description.devices.get(body.device)
    if body.device and (device is None or (body.signal and body.signal not in device.signals)):
        raise ApiProblem(422, "invalid", "the site has no such device or signal")


def _may(asker: Who, right: Right, kept: KeptNote) -> bool:
    return asker.grants.has_right(right, kept.site, kept.body.device or ANY)


def _may_change(asker: Who, kept: KeptNote) -> bool:
    own = kept.author == asker.user and _may(asker, Right.USE, kept)
    return own or _may(asker, Right.ADMIN, kept)


def _note_shape(kept: KeptNote, asker: Who) -> NoteShape:
    return NoteShape(
        id=str(kept.id),
        who=kept.who,
        created_us=kept.created_us,
        changed_us=kept.changed_us,
        changed_by=kept.changed_by,
        version=kept.version,
        may_change=_may_change(asker, kept) and not asker.display,
        **kept.body._asdict(),
    )


def _utc(time_us: int) -> str:
    return (dt.datetime(1970, 1, 1, tzinfo=dt.UTC) + dt.timedelta(microseconds=time_us)).isoformat(
        timespec="milliseconds"
    )


async def _write_csv(rows: AsyncIterator[KeptNote]) -> AsyncIterator[str]:
    buffer = io.StringIO(newline="")
    lines = csv.writer(buffer)
    lines.writerow(_HEAD)
    async for note in rows:
        body = note.body
        cells = (
            _utc(body.from_us),
            _utc(body.to_us),
            # A spreadsheet would run a cell that begins like a formula.
            safe_cell(body.device),
            safe_cell(body.signal),
            safe_cell(note.who),
            safe_cell(body.text),
            _utc(note.changed_us),
            safe_cell(note.changed_by),
        )
        lines.writerow(cells)
        if buffer.tell() > _CHUNK:
            yield buffer.getvalue()
            buffer.seek(0)
            buffer.truncate()
    yield buffer.getvalue()
