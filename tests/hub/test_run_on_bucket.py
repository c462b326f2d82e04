"""Hubs as processes whose files are in a bucket: what they refuse, and that each finds them."""

from __future__ import annotations

import hashlib
import os
import signal
from zlib import crc32

import pytest
import websockets
from async_program import start_program
from patience import until_answered

from talaia.wire.frames import FILES_FROM_GATEWAY, FILES_FROM_HUB, PIECE, FileOffer, FilePiece

from .conftest import DESCRIPTION
from .databases import empty_database
from .object_stores import BUCKET, KEY_ID, SECRET, ObjectStore, require_store
from .several_hubs import Hubs, Nats

RECORDED = DESCRIPTION + "\nrecording: {before: 20}\n"
BODY = os.urandom(9 * 1024 * 1024 + 5)
NAME = "20260101T120000Z-abcdef"
FILE = f"/api/sites/agv/recordings/{NAME}/file"


def key_file(folder):
    file = folder / "bucket-key"
    file.write_text(f"{KEY_ID}\n{SECRET}\n")
    return str(file)


async def start_refused(folder, url, bucket=BUCKET, *script):
    """Start a hub that cannot; give all that it prints."""
    words = ["hub", "--plain", "--port", "0", "--data", str(folder / "data")]
    words += ["--files", f"s3://{bucket}/files", "--files-endpoint", url]
    words += ["--files-key-file", key_file(folder)]
    hub = await start_program(*(script or ("-m", "talaia")), *words, with_errors=True)
    output, errors = await hub.communicate()
    assert hub.returncode == 2
    said = (output + errors).decode()
    # Not even what the store says of the key.
    assert SECRET not in said
    assert KEY_ID not in said
    return said


async def test_a_hub_does_not_start_with_a_bucket_that_it_cannot_use(tmp_path) -> None:
    # This one looks at keys and signatures once the bucket is made.
    async with ObjectStore(INITIAL_NO_AUTH_ACTION_COUNT="1") as store:
        said = await start_refused(tmp_path, store.url)
        assert f"--files: s3://{BUCKET}/files at {store.url} refuses the key" in said
        assert "let the hub list, read, write and delete there" in said
    said = await start_refused(tmp_path, store.url)
    assert "cannot be reached; look whether it runs, and at its address" in said
    async with ObjectStore() as store:
        said = await start_refused(tmp_path, store.url, "nobodys")
        assert "no such bucket" in said
        assert "make the bucket, or name another" in said
    assert not (tmp_path / "data" / "talaia.db").exists()


async def test_a_hub_without_the_library_says_what_to_install(tmp_path) -> None:
    script = tmp_path / "without.py"
    script.write_text(
        "import sys\nsys.modules['obstore'] = None\n"
        "from talaia.cli.main import main\nsys.exit(main(sys.argv[1:]))\n"
    )
    said = await start_refused(tmp_path, "http://127.0.0.1:9", BUCKET, str(script))
    assert "pip install 'talaia[s3]'" in said


@pytest.fixture
def postgresql_url():
    require_store()
    with empty_database("postgresql") as url:
        yield url


async def bring_recording(hubs, hub) -> None:
    """Hand a recording over at a hub as a gateway does, until it is acknowledged."""
    headers = {"Authorization": f"Bearer {hubs.gateway_key}"}
    address = f"ws://127.0.0.1:{hub.port}/gateway/files"
    async with websockets.connect(address, additional_headers=headers, proxy=None) as socket:

        async def ask(message):
            await socket.send(FILES_FROM_GATEWAY.encode(message))
            return FILES_FROM_HUB.decode(await socket.recv())

        digest = hashlib.sha256(BODY).hexdigest()
        has = await ask(FileOffer(id=NAME, size=len(BODY), digest=digest, begin_us=1, end_us=2))
        while not has.done:
            data = BODY[has.have : has.have + PIECE]
            has = await ask(FilePiece(id=NAME, at=has.have, check=crc32(data), data=data))


async def test_hubs_with_folders_of_their_own_find_each_others_recordings(
    postgresql_url, tmp_path
) -> None:
    async with (
        ObjectStore() as store,
        Nats() as nats,
        Hubs(postgresql_url, nats, tmp_path) as hubs,
    ):
        words = ["--files", f"s3://{BUCKET}/files", "--files-endpoint", store.url]
        words += ["--files-key-file", key_file(tmp_path)]
        lead = await hubs.add("east", *words)
        await lead.until_leads()
        await hubs.set_up(lead)
        other = await hubs.add("west", *words)
        await other.until_ready()
        gateway = await hubs.gateway(other)
        await gateway.hello(RECORDED)
        # Over the hub that waits, to the one that leads, into the bucket.
        await bring_recording(hubs, other)
        for hub in (lead, other):
            assert (await hubs.get(hub, FILE)).content == BODY
            async with hub.client() as client:
                asked = {"Cookie": hubs.cookie, "Range": "bytes=5000000-5000099"}
                some = await client.get(FILE, headers=asked)
            assert (some.status_code, some.content) == (206, BODY[5_000_000:5_000_100])
        lead.signal(signal.SIGKILL)
        await other.until_leads()

        async def is_whole() -> bool:
            answer = await hubs.get(other, FILE)
            return answer.status_code == 200 and answer.content == BODY

        await until_answered(is_whole)
        # Nobody's folder has it.
        assert not list(tmp_path.glob("*/recordings/*/*"))
