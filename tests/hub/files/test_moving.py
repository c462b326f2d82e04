"""A folder is moved into a bucket: nothing is removed that is not there, and it goes on later."""

from __future__ import annotations

import os

import pytest
import pytest_asyncio
from async_program import start_program

from talaia.hub.errors import FilesDown
from talaia.hub.files.bucket_address import BucketAddress, BucketKey
from talaia.hub.files.bucket_client import BucketClient
from talaia.hub.files.moving import FileMover
from talaia.hub.lock import hub_lock

from ..object_stores import BUCKET, KEY_ID, SECRET, FaultyLine, ObjectStore

FIRST = "recordings/agv/20260101T120000Z-abcdef"
FRAME = "archive/agv/2026-01-01/20260101T010000_camera_abcdef01.fits"


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def store():
    async with ObjectStore() as running:
        yield running


@pytest.fixture
async def line(store):
    for key in await store.keys():
        await store.remove(key)
    with FaultyLine(store.port) as made:
        yield made


WHOLE = {
    f"{FIRST}.json": b"{}",
    f"{FIRST}.mcap": os.urandom(9 * 1024 * 1024),
    FRAME: os.urandom(2880),
}
PARTS = {
    "recordings/agv/20260101T130000Z-aaaaaa.mcap.part": b"half of it",
    "recordings/agv/20260101T130000Z-aaaaaa.json": b"{}",
    "archive/agv/2026-01-01/x.measured": b"half of it",
}


@pytest.fixture
def folder(tmp_path):
    """A data folder with a recording, a picture, and what is not whole."""
    for name, data in (WHOLE | PARTS).items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(data)
    return tmp_path


def mover(line, folder, *, remove=True):
    address = BucketAddress(BUCKET, "site", line.url, "us-east-1", BucketKey(KEY_ID, SECRET))
    return FileMover(BucketClient(address), folder, remove=remove, tell=lambda _line: None)


def names_in(folder):
    return {
        path.relative_to(folder).as_posix()
        for path in folder.rglob("*")
        if path.is_file() and path.parent != folder
    }


async def kept(store):
    return {key.removeprefix("site/"): await store.content(key) for key in await store.keys()}


async def test_whole_files_are_moved_and_what_is_on_its_way_stays(line, folder, store) -> None:
    result = await mover(line, folder).move_all()
    assert (result.copied, result.there) == (3, 0)
    assert await kept(store) == WHOLE
    assert names_in(folder) == set(PARTS)


@pytest.mark.parametrize("fault", ["lose", "spoil"])
async def test_nothing_is_removed_that_the_store_does_not_have(line, folder, store, fault) -> None:
    setattr(line, fault, True)
    with pytest.raises(FilesDown, match="other than what was written"):
        await mover(line, folder).move_all()
    assert names_in(folder) == set(WHOLE) | set(PARTS)
    setattr(line, fault, False)
    await mover(line, folder).move_all()
    assert await kept(store) == WHOLE


async def test_a_move_that_is_broken_off_goes_on_and_writes_nothing_twice(
    line, folder, store
) -> None:
    line.refusal = (507, "InsufficientStorage")
    with pytest.raises(FilesDown, match="no room"):
        await mover(line, folder).move_all()
    line.refusal = None
    copied = await mover(line, folder, remove=False).move_all()
    assert copied.copied == 3
    assert names_in(folder) == set(WHOLE) | set(PARTS)
    line.asked.clear()
    again = await mover(line, folder).move_all()
    assert (again.copied, again.there) == (0, 3)
    assert not [path for method, path in line.asked if method in {"PUT", "POST"}]
    assert names_in(folder) == set(PARTS)
    assert await kept(store) == WHOLE


async def test_what_was_copied_and_then_deleted_does_not_come_back(line, folder, store) -> None:
    await mover(line, folder, remove=False).move_all()
    # A hub that still runs on the folder deletes a recording, and writes a picture anew.
    (folder / f"{FIRST}.mcap").unlink()
    (folder / f"{FIRST}.json").unlink()
    (folder / FRAME).write_bytes(b"measured".ljust(2880))
    result = await mover(line, folder).move_all()
    assert (result.copied, result.deleted) == (1, 2)
    assert await kept(store) == {FRAME: b"measured".ljust(2880)}
    # What was moved, and is not here any more for that, stays there.
    assert (await mover(line, folder).move_all()).deleted == 0
    assert await kept(store) == {FRAME: b"measured".ljust(2880)}


async def run_command(line, folder, *more):
    key = folder / "bucket-key"
    key.write_text(f"{KEY_ID}\n{SECRET}\n")
    words = ["--data", str(folder), "--files", f"s3://{BUCKET}/site", "--files-endpoint", line.url]
    program = await start_program(
        "-m", "talaia", "move-files", *words, "--files-key-file", str(key), *more, with_errors=True
    )
    output, errors = await program.communicate()
    return program.returncode, output.decode(), errors.decode()


async def test_the_command_only_copies_while_a_hub_has_the_folder(line, folder, store) -> None:
    with hub_lock(folder):
        code, output, errors = await run_command(line, folder)
        assert (code, errors) == (0, "")
        assert "3 files written" in output
        assert "a hub runs on this folder" in output
        assert names_in(folder) == set(WHOLE) | set(PARTS)
        # One that writes to the bucket itself is not written over.
        (folder / "files.url").write_text(f"s3://{BUCKET}/site\n")
        code, _, errors = await run_command(line, folder)
        assert code == 2
        assert "a hub that keeps its files in a bucket runs" in errors
    code, output, errors = await run_command(line, folder)
    assert (code, errors) == (0, "")
    assert f"3 of 3, 0.01 of 0.01 GB: {FRAME}" in output
    assert "0 files written" in output
    assert names_in(folder) == set(PARTS)
    assert await kept(store) == WHOLE
    assert SECRET not in output
