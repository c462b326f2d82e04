"""Where recordings and pictures are kept: the data folder, or a bucket of an object store."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.hub.features.feature import BackgroundTask, Feature
from talaia.hub.files.bucket_address import read_bucket_address
from talaia.hub.files.local_folder import LocalFolder
from talaia.hub.files.store_mark import write_mark

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from talaia.hub.features.feature import Core
    from talaia.hub.files.bucket import Bucket
    from talaia.hub.files.ports import FileStore

__all__ = ["FilesFeature"]

# Of a bucket's files that programs of this machine read (bytes).
_MOST_COPIES = 2_000_000_000


class FilesFeature(Feature):
    """The place of whole files.

    Attributes:
        store: that place.

    """

    name = "files"

    def __init__(self, core: Core) -> None:
        """Keep files where the settings say.

        Raises:
            CannotStart: the settings do not fit, or the library is missing.

        """
        self.store: FileStore
        self._data, self._url = core.settings.data, core.settings.files
        self._bucket = _make_bucket(core)
        if self._bucket is None:
            self.store = LocalFolder(core.settings.data)
            return
        self.store = self._bucket
        self.tasks = [
            BackgroundTask(name="remove", run=self._bucket.remove_for_ever),
            BackgroundTask(name="watch", run=self._bucket.watch_store),
        ]

    async def open(self) -> None:
        """Write down where files are; begin without the copies of a run before."""
        await asyncio.to_thread(write_mark, self._data, self._url)
        if self._bucket is not None:
            await asyncio.to_thread(self._bucket.prepare_disk)


def _make_bucket(core: Core) -> Bucket | None:
    address = read_bucket_address(core.settings)
    if address is None:
        return None
    # Only here: a hub whose files are in its folder imports nothing of it.
    from talaia.hub.files.bucket import Bucket
    from talaia.hub.files.bucket_client import BucketClient
    from talaia.hub.files.local_copies import LocalCopies
    from talaia.hub.store.sites.file_removals import FileRemovals

    data = core.settings.data
    return Bucket(
        BucketClient(address),
        url=address.url,
        folder=data,
        # Each begins without those of a run before: of another shard, they are in use.
        copies=LocalCopies(data / f"copies{core.shard.suffix}", _MOST_COPIES),
        removals=FileRemovals(core.database),
        removes=None if core.shard.is_whole else _own_files(core),
    )


def _own_files(core: Core) -> Callable[[str], Awaitable[bool]]:
    async def is_own(key: str) -> bool:
        # ``recordings/site/…`` and ``archive/site/…``; what is of no site is the main shard's.
        return await core.shard.look_up(key.split("/")[1] if key.count("/") > 1 else "")

    return is_own
