"""What the hub expects of a place where whole files are kept."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, NamedTuple, Protocol

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Sequence
    from contextlib import AbstractAsyncContextManager
    from pathlib import Path
    from typing import BinaryIO

__all__ = ["FileStore", "OpenFile", "Openable", "StoredFile"]


class StoredFile(NamedTuple):
    """A whole file.

    Attributes:
        key: its name in the store: folders and a name, with slashes between.
        size: bytes.
        changed_us: when it was written (µs, UTC).
        version: of its content; a file that is written anew has another one.

    """

    key: str
    size: int
    changed_us: int
    version: str


class OpenFile(Protocol):
    """A file that is read piece by piece, and stays the same meanwhile.

    Attributes:
        size: bytes.
        version: see `StoredFile`.

    """

    size: int
    version: str

    async def read_part(self, at: int, count: int) -> bytes:
        """Read up to ``count`` bytes; fewer only where the file on a disk was cut off.

        Raises:
            FilesDown: the store does not answer, or with something else.
            OSError: the disk does not.

        """
        ...

    async def close(self) -> None:
        """Let go of it."""
        ...


class Openable(Protocol):
    """A file that blocking code opens by itself, such as a `Path`."""

    def open(self, mode: Literal["rb"], /) -> BinaryIO:
        """Open it to be read at any place.

        Raises:
            FileNotFoundError: there is none.
            FilesDown: the store does not answer; also while it is read.

        """
        ...


class FileStore(Protocol):
    """Whole files by key. Who writes one with a key that is there takes its place, at once.

    Attributes:
        remote: files are elsewhere than on this machine's disk.
        trouble: why it does not take or give files now; empty while all is well.

    """

    @property
    def remote(self) -> bool:
        """See there."""
        ...

    @property
    def trouble(self) -> str:
        """See there."""
        ...

    async def keep_file(self, key: str, path: Path, *, near: bool = False) -> None:
        """Take a whole file of this machine's disk; it is moved, and safe on return.

        ``near``: it is read again soon, on this machine.

        Raises:
            FilesDown: it cannot be taken now; ``path`` is as it was.
            OSError: the disk does not take it; ``path`` is as it was.

        """
        ...

    def find_local(self, key: str) -> Path | None:
        """Give where a file lies on this machine's disk; None: it does not. Blocks."""
        ...

    async def open_file(self, key: str) -> OpenFile:
        """Open a file.

        Raises:
            FileNotFoundError: there is none.
            FilesDown: the store does not answer.

        """
        ...

    def name_file(self, key: str) -> Openable:
        """Give what blocking code opens; nothing is looked up yet."""
        ...

    def copy_file(self, key: str) -> AbstractAsyncContextManager[Path]:
        """Have a file on this machine's disk for as long as the block lasts; not to be written.

        Raises:
            FileNotFoundError: there is none.
            FilesDown: the store does not answer.
            OSError: the disk does not take it.

        """
        ...

    async def remove_files(self, keys: Sequence[str]) -> None:
        """Remove files; one that cannot be removed now is removed later, also after a restart.

        Raises:
            StoreDown: neither is possible now; nothing was removed.

        """
        ...

    def list_files(self, folder: str) -> AsyncIterator[StoredFile]:
        """List all files elsewhere than on this machine's disk, below a folder.

        Raises:
            FilesDown: the store does not answer.

        """
        ...

    def address_of(self, key: str) -> str:
        """Give the address of a file for programs of others; empty: it is on the disk."""
        ...
