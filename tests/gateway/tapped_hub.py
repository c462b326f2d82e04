"""What a hub of the tests has heard of raw topics."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.wire.frames import TapMessage, TopicList

if TYPE_CHECKING:
    from fake_hub import FakeHub


def newest_list(hub: FakeHub) -> dict[str, tuple[int, str, bool]]:
    lists = [said for said in hub.taps if isinstance(said, TopicList)]
    entries = lists[-1].topics if lists else []
    return {entry.topic: (entry.number, entry.type, entry.latched) for entry in entries}


def pieces(hub: FakeHub, topic: str) -> list[TapMessage]:
    entry = newest_list(hub).get(topic)
    number = None if entry is None else entry[0]
    return [said for said in hub.taps if isinstance(said, TapMessage) and said.number == number]


def whole(hub: FakeHub, topic: str) -> list[bytes]:
    """Put the messages of a topic together, of which all pieces are here.

    It is asked with each piece: what is not whole is not copied.
    """
    found: dict[int, list[TapMessage]] = {}
    for piece in pieces(hub, topic):
        parts = found.setdefault(piece.seq, [])
        assert piece.at == (parts[-1].at + len(parts[-1].data) if parts else 0)
        assert piece.at + len(piece.data) <= piece.size
        parts.append(piece)
    return [
        b"".join(part.data for part in parts)
        for parts in found.values()
        if parts[-1].at + len(parts[-1].data) == parts[-1].size
    ]
