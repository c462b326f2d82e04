"""Whether a bucket can be used, asked once at the start: so that a wrong key is told at once."""

from __future__ import annotations

import secrets
from typing import TYPE_CHECKING

from talaia.hub.errors import CannotStart, FilesDown
from talaia.hub.files.bucket_address import read_bucket_address
from talaia.hub.files.bucket_client import BucketClient

if TYPE_CHECKING:
    from talaia.hub.files.bucket_address import BucketAddress
    from talaia.hub.settings import Settings

__all__ = ["check_bucket", "check_files"]


async def check_files(settings: Settings) -> None:
    """See `check_bucket`; a hub whose files are in its folder asks nothing.

    Raises:
        CannotStart: the bucket cannot be used.

    """
    if (address := read_bucket_address(settings)) is not None:
        await check_bucket(BucketClient(address), address)


async def check_bucket(client: BucketClient, address: BucketAddress) -> None:
    """Write, read, list and remove a small file.

    Raises:
        CannotStart: one of these cannot be done; says which store, why, and what to do.

    """
    # Of its own: several hubs may start at once.
    key, data = f".talaia-check-{secrets.token_hex(8)}", secrets.token_bytes(16)
    try:
        await client.write_bytes(key, data)
        found = await client.find_file(key)
        read = await client.read_range(found, 0, found.size)
        async for _ in client.list_files(".talaia-nothing"):
            break
        await client.delete_file(key)
    except FilesDown as error:
        why = error.problem.removeprefix("the store of files ")
        raise CannotStart(f"--files: {address.place} {why}", error.remedy) from None
    except FileNotFoundError:
        raise CannotStart(
            f"--files: {address.place}: there is no such bucket, or what is written is not there",
            "make the bucket, or name another",
        ) from None
    if read != data:
        raise CannotStart(
            f"--files: {address.place} gives other bytes than were written", "its log may say why"
        )
