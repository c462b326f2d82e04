"""``talaia move-files``: recordings and pictures of a data folder into a bucket."""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.cli.errors import CliError
from talaia.hub.errors import CannotStart, FilesDown
from talaia.hub.files.bucket_address import read_bucket_address
from talaia.hub.files.bucket_check import check_bucket
from talaia.hub.files.bucket_client import BucketClient
from talaia.hub.files.moving import FileMover
from talaia.hub.files.store_mark import read_mark
from talaia.hub.files_options import add_files_options, read_files_settings
from talaia.hub.lock import HubRuns, hub_lock

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.hub.files.bucket_address import BucketAddress

__all__ = ["main"]


def main(argv: Sequence[str]) -> int:
    """Move them, and say how far it is."""
    options = _parse_options(argv)
    data: Path = options.data
    if not data.is_dir():
        raise CliError(f"--data: {data} is no folder; name the hub's data folder")
    settings = read_files_settings(options, data)
    address = read_bucket_address(settings)
    if address is None:
        raise CliError("--files: expected the address of a bucket, like s3://bucket/folder")
    with contextlib.ExitStack() as stack:
        try:
            stack.enter_context(hub_lock(data))
        except HubRuns:
            if read_mark(data):
                # It writes pictures anew there, over which ours would come.
                raise CannotStart(
                    "a hub that keeps its files in a bucket runs on this data folder",
                    "end it, and run this again",
                ) from None
            runs = True
        else:
            runs = False
        asyncio.run(_move_files(address, data, remove=not runs))
    if runs:
        print(
            "all is copied, and nothing was removed: a hub runs on this folder. End it, run this"
            " once more, and start the hub with --files"
        )
    return 0


async def _move_files(address: BucketAddress, data: Path, *, remove: bool) -> None:
    client = BucketClient(address)
    await check_bucket(client, address)
    try:
        result = await FileMover(client, data, remove=remove, tell=_print_line).move_all()
    except FilesDown as error:
        raise CliError(
            f"{error}; what was moved stays there: run this again to go on with the rest"
        ) from None
    except OSError as error:
        raise CliError(f"a file cannot be read: {error}; run this again to go on") from error
    print(
        f"{result.copied} files written to {address.url} and read back, {result.there} were there"
        f" already, {result.deleted} deleted there; {result.total_bytes / 1e9:.2f} GB in all"
    )


def _print_line(line: str) -> None:
    print(line)
    # Whoever reads it through a pipe sees how far it is.
    sys.stdout.flush()


def _parse_options(argv: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        "talaia move-files",
        description="Move recordings, films and the archive's pictures of a hub's data folder into"
        " a bucket. Each is read back there and compared before it is removed here; broken off, it"
        " goes on where it was. While a hub runs on the folder, files are only copied.",
    )
    parser.add_argument("--data", type=Path, required=True, help="the hub's data folder")
    add_files_options(parser, required=True)
    return parser.parse_args(argv)
