"""Reads a notice in whichever of the known forms it came. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.wire.alerts.gcn_json import parse_gcn_json
from talaia.wire.alerts.voevent import parse_voevent

if TYPE_CHECKING:
    from talaia.wire.alerts.notice import AlertNotice

__all__ = ["parse_notice"]


def parse_notice(data: bytes) -> AlertNotice:
    """Read VOEvent (XML) or GCN's unified schema (JSON).

    Raises:
        PeerError: it is neither, or says what cannot be.

    """
    # XML begins with <, after a mark of the byte order at the most; JSON never does.
    begins = data[:100].removeprefix(b"\xef\xbb\xbf").lstrip()
    return parse_voevent(data) if begins.startswith(b"<") else parse_gcn_json(data)
