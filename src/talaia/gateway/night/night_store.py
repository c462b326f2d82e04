"""What a night keeps on disk: who armed it, what is asked, what was done. Blocks on the disk."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

import msgspec

from talaia.gateway.night.arming import NightArming
from talaia.gateway.night.observation_book import BookContent
from talaia.gateway.night.request_intake import RequestSet
from talaia.gateway.persistence import read_whole, write_whole

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["NightStore"]

T = TypeVar("T")


class NightStore:
    """Three files in one folder, each written whole. From one thread.

    Raises:
        SpoolError: a file is damaged; it is not guessed who armed a roof.

    """

    def __init__(self, folder: Path) -> None:
        """Use ``folder``, which is made when something is written first."""
        self._folder = folder

    def read_arming(self) -> NightArming:
        """Give who has armed it."""
        return self._read("arming", NightArming)

    def read_requests(self) -> RequestSet:
        """Give what is asked."""
        return self._read("requests", RequestSet)

    def read_observations(self) -> BookContent:
        """Give what was done."""
        return self._read("observations", BookContent)

    def write_arming(self, arming: NightArming) -> None:
        """Keep it; raises `OSError` when the disk does not take it."""
        self._write("arming", msgspec.json.encode(arming))

    def write_requests(self, requests: RequestSet) -> None:
        """Keep it; raises `OSError` when the disk does not take it."""
        self._write("requests", msgspec.json.encode(requests))

    def write_observations(self, content: bytes) -> None:
        """Keep it, encoded already; raises `OSError` when the disk does not take it."""
        self._write("observations", content)

    def _read(self, name: str, kind: type[T]) -> T:
        return read_whole(self._folder / f"{name}.json", kind, kind)

    def _write(self, name: str, data: bytes) -> None:
        self._folder.mkdir(exist_ok=True, mode=0o700)
        write_whole(self._folder / f"{name}.json", data)
