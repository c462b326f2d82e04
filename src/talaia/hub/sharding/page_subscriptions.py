"""Which shard has which of a page's subscriptions, and how each was asked for. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.sharding.page_frames import data_of, read_asked
from talaia.hub.sharding.plan import MAIN
from talaia.wire.browser import FROM_BROWSER, Unsubscribe

if TYPE_CHECKING:
    from starlette.types import Message

__all__ = ["PageSubscriptions", "end_message"]

# Twice as many subscriptions as one lead grants a page, and what they may weigh (bytes).
_MOST, _MOST_BYTES = 512, 4 * 1024 * 1024
# Numbers that are in use, most of them refused by then; and ended ones of which values may still be
# under way.
_MOST_NUMBERS, _MOST_ENDED = 4_096, 1_024


class PageSubscriptions:
    """The subscriptions of one page, by its own numbers.

    Attributes:
        moved: numbers that another shard had before: what that one still says under them is of
            then.
        complete: all that is asked for is remembered.

    """

    def __init__(self) -> None:
        """Begin with none."""
        self.moved: set[int] = set()
        self.complete = True
        # By number; and of those that ended last.
        self._owners: dict[int, str] = {}
        self._ended: dict[int, str] = {}
        # How they were asked for, and which ask for a site.
        self._asked: dict[int, Message] = {}
        self._of_site: dict[str, dict[int, None]] = {}
        self._bytes = 0

    @property
    def is_full(self) -> bool:
        """Whether a page uses more numbers than any page needs."""
        return len(self._owners) > _MOST_NUMBERS

    def add(self, sub: int, shard: str, message: Message) -> str | None:
        """Take one in; give the other shard that has its number now, if one has."""
        before = self._owners.pop(sub, None)
        if (before or self._ended.pop(sub, shard)) != shard:
            self.moved.add(sub)
        self._forget(sub)
        self._owners[sub] = shard
        size = len(data_of(message))
        if len(self._asked) < _MOST and self._bytes + size <= _MOST_BYTES:
            self._asked[sub] = message
            self._bytes += size
            self._of_site.setdefault(_site_of(message), {})[sub] = None
        else:
            self.complete = False
        return None if before == shard else before

    def remove(self, sub: int) -> str:
        """Let one go; give the shard that has it."""
        self._forget(sub)
        owner = self._owners.pop(sub, None)
        if owner is None:
            return MAIN
        self._ended[sub] = owner
        if len(self._ended) > _MOST_ENDED:
            del self._ended[next(iter(self._ended))]
        return owner

    def of_shard(self, shard: str) -> list[Message]:
        """Give how those of a shard were asked for, in that order."""
        return [message for sub, message in self._asked.items() if self._owners[sub] == shard]

    def of_site(self, site: str) -> list[tuple[int, Message]]:
        """Give how those of a site were asked for, with their numbers."""
        return [(sub, self._asked[sub]) for sub in self._of_site.get(site, ())]

    def is_from(self, sub: int, shard: str) -> bool:
        """Tell whether what a shard says under a number is of what the page has under it."""
        return sub not in self.moved or self._owners.get(sub, self._ended.get(sub)) == shard

    def _forget(self, sub: int) -> None:
        asked = self._asked.pop(sub, None)
        if asked is None:
            return
        self._bytes -= len(data_of(asked))
        site = _site_of(asked)
        of_site = self._of_site[site]
        del of_site[sub]
        if not of_site:
            del self._of_site[site]


def _site_of(message: Message) -> str:
    asked = read_asked(data_of(message))
    return "" if asked is None else asked.site


def end_message(sub: int, like: Message) -> Message:
    """Write that a subscription ends, in the form of another message of the page."""
    ended = Unsubscribe(sub=sub)
    if like.get("bytes") is None:
        return {"type": "websocket.receive", "text": FROM_BROWSER.encode_text(ended)}
    return {"type": "websocket.receive", "bytes": FROM_BROWSER.encode(ended)}
