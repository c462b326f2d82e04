"""One picture of a film, with all that a decoder needs for it, in one answer."""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.live.files.recording_files import file_key
from talaia.hub.live.recorded.errors import RecordingUnreadable
from talaia.hub.live.recorded.film_index import find_tables, read_index

if TYPE_CHECKING:
    from talaia.hub.files.ports import FileStore, OpenFile
    from talaia.hub.live.recorded.film_index import FilmIndex
    from talaia.hub.store.sites.recordings import Recorded

__all__ = ["FilmPictures", "FoundPicture"]

# Films whose tables are held, and pictures of all of them: each takes 32 bytes.
_MOST_INDEXES, _MOST_PICTURES = 24, 1_500_000
# The tables of ten minutes stand in so many first bytes; of a longer film the rest is read.
_FIRST_BYTES = 256 * 1024
# More than the tables of any film take, and than what stands between two whole pictures.
_MOST_TABLES, _MOST_BYTES = 32 * 1024 * 1024, 8 * 1024 * 1024


class FoundPicture(NamedTuple):
    """A picture, after those that it is made from.

    Attributes:
        codec: see `FilmIndex`.
        description: see `FilmIndex`.
        times_us: when each of them came (UTC), rising; the last one is the picture.
        before_us: when the one before it came (UTC); None: it is the film's first.
        next_us: when the one after it did; None: it is the film's last.
        data: of each, as it stands in the file; the first needs none before it.

    """

    codec: str
    description: bytes
    times_us: list[int]
    before_us: int | None
    next_us: int | None
    data: list[bytes]


class FilmPictures:
    """Reads pictures out of films."""

    def __init__(self, store: FileStore) -> None:
        """Read the films of ``store``."""
        self._store = store
        # By key and size, since a whole file never changes; the one used last stands last.
        self._indexes: OrderedDict[tuple[str, int], FilmIndex] = OrderedDict()

    async def find_picture(self, film: Recorded, at_us: int) -> FoundPicture:
        """Give the picture that stands at a moment (µs, UTC): the last that has come.

        Raises:
            RecordingUnreadable: the file is not as films of ours are.
            FileNotFoundError: it is not there.
            FilesDown: the store does not answer.
            OSError: the disk does not.

        """
        file = await self._store.open_file(file_key(film))
        try:
            index = await self._index_of(film, file)
            return await _read_picture(film, index, file, at_us)
        finally:
            await file.close()

    async def _index_of(self, film: Recorded, file: OpenFile) -> FilmIndex:
        key = (file_key(film), film.size)
        index = self._indexes.get(key)
        if index is None:
            index = self._indexes[key] = await _load_index(file)
        self._indexes.move_to_end(key)
        while len(self._indexes) > 1 and self._holds_too_much():
            self._indexes.popitem(last=False)
        return index

    def _holds_too_much(self) -> bool:
        pictures = sum(len(index.sizes) for index in self._indexes.values())
        return len(self._indexes) > _MOST_INDEXES or pictures > _MOST_PICTURES


async def _load_index(file: OpenFile) -> FilmIndex:
    head = await file.read_part(0, _FIRST_BYTES)
    found = find_tables(head)
    if found is None or found[1] - found[0] > _MOST_TABLES:
        raise RecordingUnreadable("the film's tables do not stand in front")
    begin, end = found
    if end > len(head):
        head += await file.read_part(len(head), end - len(head))
    return await asyncio.to_thread(read_index, head[begin:end], file.size)


async def _read_picture(
    film: Recorded, index: FilmIndex, file: OpenFile, at_us: int
) -> FoundPicture:
    picture = index.picture_at(at_us - film.begin_us)
    first, after = int(index.keys[picture]), picture + 1
    offsets, sizes = index.offsets[first:after].tolist(), index.sizes[first:after].tolist()
    places = list(zip(offsets, sizes, strict=True))
    begin, end = min(at for at, _ in places), max(at + size for at, size in places)
    # Tables can have pictures lie upon each other.
    if max(end - begin, sum(sizes)) > _MOST_BYTES:
        raise RecordingUnreadable("too much stands between two whole pictures of the film")
    data = await file.read_part(begin, end - begin)
    if len(data) < end - begin:
        raise RecordingUnreadable("the film is shorter than its tables say")
    times_us = [film.begin_us + int(us) for us in index.times_us[first:after]]
    return FoundPicture(
        codec=index.codec,
        description=index.description,
        times_us=times_us,
        before_us=_time_of(film, index, picture - 1),
        next_us=_time_of(film, index, after),
        data=[data[at - begin : at - begin + size] for at, size in places],
    )


def _time_of(film: Recorded, index: FilmIndex, picture: int) -> int | None:
    within = 0 <= picture < len(index.times_us)
    return film.begin_us + int(index.times_us[picture]) if within else None
