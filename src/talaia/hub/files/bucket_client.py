"""Asks an object store that speaks S3; its errors become ours here, and nowhere else."""

from __future__ import annotations

import contextlib
import datetime as dt
from typing import TYPE_CHECKING, Any, TypeVar

from talaia.hub.errors import CannotStart, FilesDown
from talaia.hub.files.ports import StoredFile
from talaia.hub.files.store_failures import describe_failure
from talaia.hub.files.store_health import StoreHealth, StoreUse

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Iterator
    from pathlib import Path

    from talaia.hub.files.bucket_address import BucketAddress

__all__ = ["PART_BYTES", "BucketClient"]

_Given = TypeVar("_Given")
# Of an upload; so many are on their way at once, and that is all the memory it takes.
PART_BYTES = 8 * 1024 * 1024
_PARTS_AT_ONCE = 2
# A store that is not there is given up after this (s): whoever waits is told to come again.
_CONNECT_S = 5
# For one part to be read, or written over a slow line (s).
_READ_S, _WRITE_S = 20, 120
# Tries after the first, and no more of them after so long (s).
_TRIES, _TRYING_S = 2, 10
_MOST_LISTED = 1000
_REPLACED = "the store of files has another file there now"


class BucketClient:
    """One bucket, below a prefix; keys are relative to it.

    Attributes:
        health: whether the store does what is asked of it.

    """

    def __init__(self, address: BucketAddress) -> None:
        """Make ready; nothing is asked yet.

        Raises:
            CannotStart: the library is missing, or does not take the address.

        """
        try:
            import obstore
            from obstore.exceptions import BaseError, PreconditionError
            from obstore.store import S3Store
        except ImportError as error:
            raise CannotStart(
                "--files needs obstore, which is not installed", "pip install 'talaia[s3]'"
            ) from error
        self.health = StoreHealth(address.place)
        self._obstore: Any = obstore
        self._replaced = PreconditionError
        # ValueError: an answer that cannot be read.
        self._failures = (BaseError, OSError, TimeoutError, ValueError)
        try:
            self._reader = _make_store(S3Store, address, _READ_S)
            self._writer = _make_store(S3Store, address, _WRITE_S)
        except (BaseError, ValueError) as error:
            # What the library says may hold the key.
            raise CannotStart(
                f"--files: {address.place} cannot be used", "look at its address and region"
            ) from error

    async def find_file(self, key: str) -> StoredFile:
        """Ask for a file's size and version.

        Raises:
            FileNotFoundError: there is none.
            FilesDown: the store does not answer.

        """
        found = await self._ask(StoreUse.READ, self._obstore.head_async(self._reader, key))
        return _stored_file(key, found)

    async def read_range(self, found: StoredFile, at: int, count: int) -> bytes:
        """Read a part of just that version of a file.

        Raises:
            FilesDown: the store does not answer, or with something else.

        """
        options = _range_options(found, at, count)
        with self._translated(StoreUse.READ):
            answer = await self._obstore.get_async(self._reader, found.key, options=options)
            data = bytes(await answer.bytes_async())
            _check_answer(found, answer.meta, options["range"], data)
        return data

    def read_range_here(self, found: StoredFile, at: int, count: int) -> bytes:
        """Do the same, and block."""
        options = _range_options(found, at, count)
        with self._translated(StoreUse.READ):
            answer = self._obstore.get(self._reader, found.key, options=options)
            data = bytes(answer.bytes())
            _check_answer(found, answer.meta, options["range"], data)
        return data

    def find_file_here(self, key: str) -> StoredFile:
        """Do as `find_file`, and block."""
        with self._translated(StoreUse.READ):
            return _stored_file(key, self._obstore.head(self._reader, key))

    async def write_file(self, key: str, path: Path, size: int) -> None:
        """Write a whole file, in the place of one that is there.

        Raises:
            FilesDown: the store does not take it.

        """
        asked = self._obstore.put_async(
            self._writer,
            key,
            path,
            use_multipart=size > PART_BYTES,
            chunk_size=PART_BYTES,
            max_concurrency=_PARTS_AT_ONCE,
        )
        try:
            await self._ask(StoreUse.WRITE, asked)
        except FileNotFoundError:
            # What is written to is never missing, unless all of it is.
            self.health.report_failure(StoreUse.WRITE, "has no such bucket")
            raise FilesDown("the store of files has no such bucket") from None

    async def write_bytes(self, key: str, data: bytes) -> None:
        """Write a small file.

        Raises:
            FileNotFoundError: there is no such bucket.
            FilesDown: the store does not take it.

        """
        await self._ask(StoreUse.WRITE, self._obstore.put_async(self._writer, key, data))

    async def delete_file(self, key: str) -> None:
        """Delete a file, if it is there.

        Raises:
            FilesDown: the store does not answer.

        """
        with contextlib.suppress(FileNotFoundError):
            await self._ask(StoreUse.WRITE, self._obstore.delete_async(self._writer, key))

    async def list_files(self, folder: str) -> AsyncIterator[StoredFile]:
        """List what is below a folder.

        Raises:
            FilesDown: the store does not answer.

        """
        listing = self._obstore.list(self._reader, folder, chunk_size=_MOST_LISTED).__aiter__()
        while True:
            try:
                batch = await self._ask(StoreUse.READ, anext(listing))
            except StopAsyncIteration:
                self.health.report_success(StoreUse.READ)
                return
            except FileNotFoundError:
                self.health.report_failure(StoreUse.READ, "has no such bucket")
                raise FilesDown("the store of files has no such bucket") from None
            for found in batch:
                yield _stored_file(found["path"], found)

    async def _ask(self, use: StoreUse, asked: Awaitable[_Given]) -> _Given:
        with self._translated(use):
            return await asked

    @contextlib.contextmanager
    def _translated(self, use: StoreUse) -> Iterator[None]:
        try:
            yield
        except FileNotFoundError:
            # It answered: there is no such file.
            if use is StoreUse.READ:
                self.health.report_success(use)
            raise
        except self._replaced:
            # It does what it should: somebody wrote the file anew while it was read.
            raise FilesDown(_REPLACED, "try again") from None
        except FilesDown as error:
            # It answered with something else than what it has.
            self.health.report_failure(use, error.problem.removeprefix("the store of files "))
            raise
        except self._failures as error:
            failure = describe_failure(str(error))
            self.health.report_failure(use, failure.why, full=failure.full)
            # Not chained: what the library says may hold a key, and would be logged with ours.
            raise FilesDown(f"the store of files {failure.why}", failure.remedy) from None
        else:
            self.health.report_success(use)


def _make_store(kind: Any, address: BucketAddress, within_s: float) -> Any:  # noqa: ANN401 - the library may be missing
    options: dict[str, Any] = {
        "connect_timeout": dt.timedelta(seconds=_CONNECT_S),
        "timeout": dt.timedelta(seconds=within_s),
        # Elsewhere than on this machine the address has TLS; see `read_bucket_address`.
        "allow_http": address.endpoint.startswith("http://"),
    }
    if address.ca:
        options["root_certificate"] = address.ca
    config: dict[str, Any] = {
        "region": address.region,
        # Files go one by one: not every store knows more at once.
        "disable_bulk_delete": True,
    }
    if address.endpoint:
        config["endpoint"] = address.endpoint
    if address.key is not None:
        config["access_key_id"] = address.key.id
        config["secret_access_key"] = address.key.secret
        if address.key.token:
            config["session_token"] = address.key.token
    return kind(
        address.bucket,
        prefix=address.prefix or None,
        config=config,
        client_options=options,
        retry_config={
            "max_retries": _TRIES,
            "retry_timeout": dt.timedelta(seconds=_TRYING_S),
            "backoff": {
                "init_backoff": dt.timedelta(seconds=0.2),
                "max_backoff": dt.timedelta(seconds=2),
                "base": 2,
            },
        },
    )


def _stored_file(key: str, found: Any) -> StoredFile:  # noqa: ANN401 - see above
    changed_us = round(found["last_modified"].timestamp() * 1e6)
    return StoredFile(key, int(found["size"]), changed_us, found["e_tag"] or "")


def _range_options(found: StoredFile, at: int, count: int) -> dict[str, Any]:
    options: dict[str, Any] = {"range": (at, min(at + count, found.size))}
    if found.version:
        options["if_match"] = found.version
    return options


def _check_answer(found: StoredFile, meta: Any, asked: tuple[int, int], data: bytes) -> None:  # noqa: ANN401 - see above
    """Refuse what is not the file that was asked for, or not all of it.

    Raises:
        FilesDown: it is not.

    """
    if int(meta["size"]) != found.size or (meta["e_tag"] or "") != found.version:
        raise FilesDown(_REPLACED)
    if len(data) != asked[1] - asked[0]:
        raise FilesDown("the store of files gives less than it has")
