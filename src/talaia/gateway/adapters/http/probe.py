"""Looks at one HTTP address: asks for it once, and tells which fields its answer has."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from talaia.gateway.adapters.http.adapter import server_of
from talaia.gateway.adapters.http.fetching import FetchFailed, HttpQuestion
from talaia.gateway.adapters.json_signals import parse_payload
from talaia.gateway.errors import AdapterLost, FieldError
from talaia.model.connection import HttpConnection
from talaia.model.discovery.json_devices import connection_of
from talaia.model.discovery.json_fields import MOST_FIELDS, fields_of_json
from talaia.model.discovery.probe_report import FORMAT, Found, TopicFound

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["probe_address"]


def probe_address(found: Found, folder: Path) -> Found:
    """Ask for the address of ``found``, as its connection would, and fill in what is there.

    Raises:
        AdapterLost: it does not answer, or with what cannot be read.
        SettingsError: a secret or the authorities cannot be read.

    """
    known = connection_of(found)
    assert known is not None  # noqa: S101 - whoever calls says which protocol it is
    settings = known[1]
    assert isinstance(settings, HttpConnection)  # noqa: S101 - likewise
    parts = urlsplit(found.url)
    get = (parts.path or "/") + (f"?{parts.query}" if parts.query else "")
    # The very code by which the gateway will ask, with its bounds and its judgement of addresses.
    began = time.monotonic()
    try:
        answer = HttpQuestion(server_of(settings, folder), get).fetch_answer()
        read = parse_payload(answer)
    except (FetchFailed, FieldError) as error:
        raise AdapterLost(f"{found.url}: {error}") from error
    # A page of HTML is text, too, and no value.
    fields = fields_of_json(read.value if read.is_json else read.text, parts.path)
    problem = "" if read.is_json or len(read.text) < 200 else "its answer is a page and no JSON"
    more = (f"has more than {MOST_FIELDS} fields",) if len(fields) == MOST_FIELDS else ()
    topic = TopicFound(
        get,
        "JSON" if read.is_json else "value",
        publishers=1,
        fields=() if problem else fields,
        left_out=more,
        problem=problem,
    )
    return Found(
        **{
            name: getattr(found, name)
            for name in ("protocol", "where", "url", "user", "password_file", "token_file", "ca")
        },
        talaia_probe=FORMAT,
        seconds=round(time.monotonic() - began, 1),
        topics=(topic,),
    )
