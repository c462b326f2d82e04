"""Whole files as answers: from the disk as ever, from a bucket piece by piece, ranges as well."""

from __future__ import annotations

import asyncio
import re
from email.utils import formatdate
from typing import TYPE_CHECKING
from urllib.parse import quote

from starlette.responses import FileResponse, Response, StreamingResponse

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Mapping

    from starlette.requests import Request

    from talaia.hub.files.ports import FileStore, OpenFile

__all__ = ["read_pieces", "send_stored_file"]

# In memory for each download; a part of a bucket's file is asked for when the last was taken.
_PIECE = 1024 * 1024
_RANGE = re.compile(r"bytes=(\d{0,18})-(\d{0,18})", re.ASCII)


async def send_stored_file(
    store: FileStore,
    key: str,
    request: Request,
    *,
    name: str,
    kind: str,
    headers: Mapping[str, str],
    disposition: str = "attachment",
) -> Response:
    """Answer with a file, or a range of it.

    Args:
        store: where it is.
        key: its name there.
        request: may ask for a range, or only for the head.
        name: for people, as it is saved.
        kind: its media type.
        headers: of the answer, besides its own.
        disposition: ``attachment``, or ``inline`` where a page shows it.

    Raises:
        FileNotFoundError: it is not there.
        FilesDown: the store does not answer.

    """
    # The disk may be slow, or a network's.
    path = await asyncio.to_thread(store.find_local, key)
    if path is not None:
        return FileResponse(
            path,
            media_type=kind,
            filename=name,
            content_disposition_type=disposition,
            headers=dict(headers),
        )
    if not store.remote:
        raise FileNotFoundError(key)
    file = await store.open_file(key)
    etag = f'"{file.version.strip(chr(34))}"'
    own = {
        **headers,
        "Accept-Ranges": "bytes",
        "ETag": etag,
        "Content-Type": kind,
        "Content-Disposition": _disposition(disposition, name),
        "Date": formatdate(usegmt=True),
    }
    span = _asked_range(request, etag, file.size)
    if span is None:
        span, status = (0, file.size), 200
    elif span[0] >= span[1]:
        await file.close()
        return Response(status_code=416, headers={"Content-Range": f"bytes */{file.size}"})
    else:
        status = 206
        own["Content-Range"] = f"bytes {span[0]}-{span[1] - 1}/{file.size}"
    own["Content-Length"] = str(span[1] - span[0])
    if request.method == "HEAD":
        await file.close()
        return Response(status_code=status, headers=own)
    return StreamingResponse(_send_span(file, *span), status, own)


async def read_pieces(file: OpenFile, at: int, end: int) -> AsyncIterator[bytes]:
    """Read a file from one place to another, piece by piece; a file that is cut off ends early."""
    while at < end:
        piece = await file.read_part(at, min(_PIECE, end - at))
        if not piece:
            return
        at += len(piece)
        yield piece


async def _send_span(file: OpenFile, at: int, end: int) -> AsyncIterator[bytes]:
    # A store that fails in the middle ends the connection: what was sent does not look whole.
    try:
        async for piece in read_pieces(file, at, end):
            yield piece
    finally:
        await file.close()


def _asked_range(request: Request, etag: str, size: int) -> tuple[int, int] | None:
    """Read which bytes are asked for; None: all, also where several ranges are.

    One that lies outside has no bytes (RFC 9110, 14.1.2).
    """
    asked = _RANGE.fullmatch(request.headers.get("range", "").strip().lower())
    # Of another version than the one that was begun: all of it.
    known = request.headers.get("if-range", etag)
    if asked is None or known != etag:
        return None
    first, last = asked.groups()
    if not first:
        return (max(0, size - int(last)), size) if last else None
    if last and int(last) < int(first):
        return None
    return int(first), min(int(last) + 1, size) if last else size


def _disposition(how: str, name: str) -> str:
    quoted = quote(name)
    return f"{how}; filename*=utf-8''{quoted}" if quoted != name else f'{how}; filename="{name}"'
