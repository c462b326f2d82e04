"""Which topics the broker may hold of ours, on disk: what goes later has to be cleared there."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

import msgspec

if TYPE_CHECKING:
    from collections.abc import Collection
    from pathlib import Path

__all__ = ["KnownTopics"]

_LOG = logging.getLogger(__name__)


class _Kept(msgspec.Struct, frozen=True):
    broker: str
    topics: list[str]


class KnownTopics:
    """A file with the topics of one broker."""

    def __init__(self, path: Path) -> None:
        """Keep them in the file ``path``."""
        self._path = path

    def load_topics(self, broker: str) -> list[str]:
        """Give the topics that a broker may hold."""
        try:
            kept = msgspec.json.decode(self._path.read_bytes(), type=_Kept)
        except FileNotFoundError:
            return []
        except (OSError, msgspec.DecodeError) as error:
            _LOG.warning("%s cannot be read; retained topics may stay: %s", self._path, error)
            return []
        if kept.broker != broker:
            _LOG.warning("retained topics stay at the broker of before, %s", kept.broker)
            return []
        return kept.topics

    def save_topics(self, broker: str, topics: Collection[str]) -> None:
        """Write them down.

        Raises:
            OSError: they cannot be written.

        """
        fresh = self._path.with_suffix(".new")
        fresh.write_bytes(msgspec.json.encode(_Kept(broker, sorted(topics))))
        fresh.replace(self._path)
