"""The archive of pictures: what comes from a gateway, is checked, kept by night and found."""

from __future__ import annotations

import asyncio
import gzip
import hashlib
import io
import math
import resource
import warnings
from datetime import UTC, datetime
from pathlib import Path
from zlib import crc32

import msgspec
import numpy as np
import pytest
from astropy.io import fits
from hypothesis import given, settings, strategies as st
from many_examples import examples

from talaia.hub.archive.fits_process import FitsProcess
from talaia.hub.archive.fits_reader import NotKept, facts_of, looks_of, preview_of
from talaia.hub.archive.frame_rows import Cone, Wanted
from talaia.hub.archive.night import night_of
from talaia.hub.archive.store import Archive
from talaia.hub.files.local_folder import LocalFolder
from talaia.hub.live.files.fits_archiver import FitsArchiver
from talaia.wire.frames import (
    FILES_FROM_GATEWAY,
    FILES_FROM_HUB,
    PIECE,
    ArchiveOffer,
    Beat,
    BeatReply,
    FileOffer,
    FilePiece,
    FileProgress,
)

# A moment in the night of 20 November at the observatory's longitude, after midnight UTC.
BEGAN = "2026-11-21T02:30:00"


def fits_bytes(target="M 31", filter_="Red", ra=10.68, dec=41.27, began=BEGAN, seed=1) -> bytes:
    rng = np.random.default_rng(seed)
    data = rng.normal(1000, 20, (60, 80)).astype(np.float32)
    data[30, 40] = 40_000
    hdu = fits.PrimaryHDU(data.astype(np.uint16))
    hdu.header["OBJECT"], hdu.header["FILTER"], hdu.header["IMAGETYP"] = target, filter_, "Light"
    hdu.header["DATE-OBS"], hdu.header["EXPTIME"] = began, 30.0
    hdu.header["RA"], hdu.header["DEC"] = ra, dec
    out = io.BytesIO()
    hdu.writeto(out)
    return out.getvalue()


def offer_of(data: bytes, name: str = "0" * 32, device="camera", kind="fits") -> ArchiveOffer:
    digest = hashlib.sha256(data).hexdigest()
    return ArchiveOffer(id=name, kind=kind, device=device, size=len(data), digest=digest, time_us=1)


class Files:
    """A gateway's connection that brings files."""

    def __init__(self, connection) -> None:  # noqa: D107
        self.connection = connection

    async def ask(self, message) -> FileProgress:
        await self.connection.send(FILES_FROM_GATEWAY.encode(message))
        return FILES_FROM_HUB.decode(await self.connection.recv())

    async def piece(self, data: bytes, offer: ArchiveOffer, at: int) -> FileProgress:
        part = data[at : at + PIECE]
        return await self.ask(FilePiece(id=offer.id, at=at, check=crc32(part), data=part))

    async def bring(
        self, data: bytes, offer: ArchiveOffer, until: int | None = None
    ) -> FileProgress:
        """Hand over all of a file as a gateway does, or no more than ``until``."""
        has = await self.ask(offer)
        while not has.done and not has.refused and has.have < (until or len(data)):
            has = await self.piece(data, offer, has.have)
        return has


async def files_of(hub) -> Files:
    key = {"Authorization": f"Bearer {hub.keys['agv']}"}
    return Files(await hub.dial("/gateway/files", key))


@pytest.fixture
async def files(hub, gateway) -> Files:
    """A connection for files beside the link, which has said what site it is."""
    del gateway
    return await files_of(hub)


async def upload(files: Files, data: bytes, **about) -> FileProgress:
    return await files.bring(data, offer_of(data, hashlib.sha256(data).hexdigest()[:32], **about))


async def test_picture_is_kept_by_night_and_comes_back_as_it_was(hub, files) -> None:
    data = fits_bytes()
    assert (await upload(files, data)).done
    client = await hub.client("operator")
    (night,) = (await client.get("/api/sites/agv/nights")).json()["nights"]
    assert night["frames"] == 1
    assert night["bytes"] >= len(data)
    (frame,) = (await client.get("/api/sites/agv/frames")).json()["frames"]
    assert frame["target"] == "M 31"
    assert frame["night"] == night["night"]
    assert frame["problems"] == []
    assert (frame["width"], frame["height"], frame["exposure_s"]) == (80, 60, 30.0)
    answer = await client.get(f"/api/sites/agv/frames/{frame['id']}/file")
    # Its header may have been given more cards meanwhile.
    assert answer.content.endswith(data[2880:])
    assert answer.headers["content-disposition"].startswith("attachment")
    assert "sandbox" in answer.headers["content-security-policy"]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with fits.open(io.BytesIO(answer.content)) as hdus:
            hdus.verify("exception")
            assert hdus[0].header["OBJECT"] == "M 31"
    detail = (await client.get(f"/api/sites/agv/frames/{frame['id']}")).json()
    assert sum(detail["histogram"]["counts"]) > 4000
    assert 950 < detail["histogram"]["median"] < 1050
    assert {"key": "OBJECT", "value": "M 31", "comment": ""} in detail["header"]
    for stretch in ("asinh", "linear", "log"):
        answer = await client.get(
            f"/api/sites/agv/frames/{frame['id']}/preview", params={"stretch": stretch}
        )
        assert answer.headers["content-type"] == "image/png"
        assert answer.content.startswith(b"\x89PNG")


async def test_upload_goes_on_where_a_lost_connection_left_it(hub, files) -> None:
    data = fits_bytes() * 30
    offer = offer_of(data)
    assert (await files.ask(offer)).have == 0
    assert (await files.bring(data, offer, until=3 * PIECE)).have == 3 * PIECE
    await files.connection.close()
    again = await files_of(hub)
    assert (await again.ask(offer)).have == 3 * PIECE
    assert (await again.bring(data, offer)).done


async def test_piece_that_came_twice_or_does_not_follow_changes_nothing(files) -> None:
    data = fits_bytes() * 10
    offer = offer_of(data)
    await files.ask(offer)
    assert (await files.piece(data, offer, PIECE)).have == 0
    assert (await files.piece(data, offer, 0)).have == PIECE
    assert (await files.piece(data, offer, 0)).have == PIECE
    assert (await files.bring(data, offer)).done


async def test_recordings_and_pictures_take_turns_on_one_connection(hub, files) -> None:
    data = fits_bytes() * 10
    offer = offer_of(data)
    assert (await files.bring(data, offer, until=PIECE)).have == PIECE
    body = b"mcap" * 100
    recording = FileOffer(
        id="20260101T120000Z-abcdef", size=len(body), digest=hashlib.sha256(body).hexdigest(),
        begin_us=1, end_us=2,
    )  # fmt: skip
    assert (await files.bring(body, recording)).done
    assert (await files.ask(offer)).have == PIECE
    assert (await files.bring(data, offer)).done


async def test_old_gateway_that_sends_pictures_on_its_link_is_not_sent_away(gateway) -> None:
    old = {"t": "upload_part", "file": "0" * 32, "offset": 0, "data": b"x"}
    await gateway.connection.send(msgspec.msgpack.encode(old))
    await gateway.say(Beat(n=7, mono_us=0))
    assert (await gateway.hear(BeatReply)).n == 7


@pytest.mark.parametrize(
    ("data", "reason"),
    [(b"<svg onload='x'/>" * 500, "not a FITS file"), (b"", "not a FITS file")],
)
async def test_what_is_no_picture_is_refused_and_leaves_nothing(hub, files, data, reason) -> None:
    state = await upload(files, data)
    assert reason in state.refused
    assert [*hub.settings.data.glob("uploads/**/*.part")] == []
    assert [*hub.settings.data.glob("archive/**/*.fits")] == []


async def test_file_of_an_unknown_kind_or_too_large_is_refused_before_it_comes(files) -> None:
    assert "'exe'" in (await files.ask(offer_of(b"x", kind="exe"))).refused
    large = ArchiveOffer(id="1" * 32, kind="fits", size=2**40, digest="0" * 64)
    assert "more than" in (await files.ask(large)).refused


async def test_damaged_file_is_not_kept_but_taken_anew(files) -> None:
    data = fits_bytes()
    offer = offer_of(data)
    await files.ask(offer)
    has = await files.piece(b"\0" * len(data), offer, 0)
    assert (has.have, has.done, has.refused) == (0, False, "")
    assert (await files.bring(data, offer)).done


async def test_same_picture_twice_is_kept_once(hub, files) -> None:
    data = fits_bytes()
    assert (await upload(files, data)).done
    assert (await files.bring(data, offer_of(data, "2" * 32))).done
    client = await hub.client("operator")
    assert len((await client.get("/api/sites/agv/frames")).json()["frames"]) == 1


async def test_pictures_are_found_by_target_filter_date_and_place(hub, files) -> None:
    for data in (
        fits_bytes("M 31", "Red", 10.68, 41.27, seed=1),
        fits_bytes("M31 halo", "Blue", 11.5, 41.0, seed=2),
        fits_bytes("Pole", "Red", 200.0, 89.9, "2026-11-22T02:00:00", seed=3),
        fits_bytes("50%_off", "Red", 359.99, 0.0, seed=4),
    ):
        assert (await upload(files, data)).done
    client = await hub.client("operator")

    async def found(**query) -> set[str]:
        answer = await client.get("/api/sites/agv/frames", params=query)
        assert answer.status_code == 200, answer.text
        return {each["target"] for each in answer.json()["frames"]}

    assert await found() == {"M 31", "M31 halo", "Pole", "50%_off"}
    assert await found(target="m 31") == {"M 31"}
    assert await found(target="%") == {"50%_off"}
    assert await found(filter="Blue") == {"M31 halo"}
    assert await found(ra=10.7, dec=41.3, radius=0.1) == {"M 31"}
    assert await found(ra=10.7, dec=41.3, radius=2) == {"M 31", "M31 halo"}
    assert await found(ra=20.0, dec=89.95, radius=0.5) == {"Pole"}
    assert await found(ra=0.01, dec=0.0, radius=0.1) == {"50%_off"}
    assert await found(target="' OR 1=1 --") == set()
    nights = (await client.get("/api/sites/agv/nights")).json()["nights"]
    assert [each["frames"] for each in nights] == [1, 3]
    assert await found(night=nights[0]["night"]) == {"Pole"}
    answer = await client.get("/api/sites/agv/frames", params={"limit": 2})
    assert (len(answer.json()["frames"]), answer.json()["more"]) == (2, True)


async def test_picture_of_a_place_is_found_behind_many_newer_ones_at_its_declination(
    hub, files, tmp_path
) -> None:
    before = "2026-11-20T02:30:00"
    for data in (
        # All of one moment, so that batches end between equal times.
        *(fits_bytes("Elsewhere", ra=100.0, seed=seed) for seed in range(5)),
        *(fits_bytes("M 31", began=before, seed=seed) for seed in range(5, 8)),
    ):
        assert (await upload(files, data)).done
    # So few are read at once that the wanted ones are not among the first.
    archive = Archive(hub.hub.core.database, LocalFolder(tmp_path), most_rows=2)
    wanted = Wanted(cone=Cone(10.68, 41.27, 0.1))
    for limit, more in ((2, True), (3, False)):
        found, are_more = await archive.find_frames("agv", ["camera"], wanted, limit)
        assert [frame.target for frame in found] == ["M 31"] * limit
        assert len({frame.id for frame in found}) == limit
        assert are_more is more


@pytest.mark.parametrize(
    "query",
    [{"ra": 1.0}, {"ra": 361, "dec": 0}, {"ra": "nan", "dec": 0}, {"limit": 0}, {"radius": 0}],
)
async def test_search_that_makes_no_sense_says_so(hub, gateway, query) -> None:
    client = await hub.client("operator")
    assert (await client.get("/api/sites/agv/frames", params=query)).status_code == 422


async def test_picture_of_a_camera_one_may_not_see_is_as_if_it_were_not_there(hub, files) -> None:
    assert (await upload(files, fits_bytes(), device="camera")).done
    operator, guest = await hub.client("operator"), await hub.client("guest")
    (frame,) = (await operator.get("/api/sites/agv/frames")).json()["frames"]
    assert (await guest.get("/api/sites/agv/frames")).json()["frames"] == []
    assert (await guest.get("/api/sites/agv/nights")).json()["nights"] == []
    for tail in ("", "/file", "/preview"):
        asked = await guest.get(f"/api/sites/agv/frames/{frame['id']}{tail}")
        assert asked.status_code == 404


@pytest.mark.parametrize(
    ("utc", "zone", "night"),
    [
        ("2026-11-21T02:30:00", "UTC", "2026-11-20"),
        ("2026-11-21T12:00:00", "UTC", "2026-11-21"),
        ("2026-11-21T11:59:59", "UTC", "2026-11-20"),
        # Noon on the wall, also in summer.
        ("2026-07-01T10:00:00", "Europe/Madrid", "2026-07-01"),
        ("2026-07-01T09:59:59", "Europe/Madrid", "2026-06-30"),
        ("2026-11-21T02:30:00", "Pacific/Honolulu", "2026-11-20"),
        ("2026-11-21T22:01:00", "Pacific/Honolulu", "2026-11-21"),
    ],
)
def test_night_lasts_from_noon_to_noon_of_the_site(utc: str, zone: str, night: str) -> None:
    at = datetime.fromisoformat(utc).replace(tzinfo=UTC)
    assert night_of(round(at.timestamp() * 1e6), zone) == night


def test_header_that_breaks_the_standard_is_kept_and_told(tmp_path) -> None:
    data = bytearray(fits_bytes())
    at = data.index(b"EXPTIME ")
    data[at : at + 30] = b"exptime =                 30.0"
    path = tmp_path / "a.fits"
    path.write_bytes(data)
    facts = facts_of(path)
    assert facts.problems
    assert (facts.width, facts.height) == (80, 60)


def test_picture_cut_short_is_told(tmp_path) -> None:
    path = tmp_path / "a.fits"
    path.write_bytes(fits_bytes()[: 2880 + 5000])
    assert any("truncated" in each for each in facts_of(path).problems)


@settings(max_examples=examples(12, many=400), deadline=None)
@given(st.binary(max_size=200), st.integers(0, 3000))
def test_hostile_files_end_in_our_own_error_or_in_facts(tmp_path_factory, noise, at) -> None:
    data = bytearray(fits_bytes())
    data[at : at + len(noise)] = noise
    path = tmp_path_factory.mktemp("hostile") / "a.fits"
    path.write_bytes(data)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            facts_of(path)
            looks_of(path)
            preview_of(path, "asinh")
        except NotKept:
            return


def test_picture_without_any_finite_value_is_drawn_all_the_same(tmp_path) -> None:
    path = tmp_path / "a.fits"
    fits.PrimaryHDU(np.full((20, 20), np.nan, np.float32)).writeto(path)
    assert math.isnan(looks_of(path).median)
    assert preview_of(path, "log").startswith(b"\x89PNG")


def test_picture_that_claims_more_pixels_than_anyone_has_is_refused(tmp_path) -> None:
    data = fits_bytes().replace(
        b"NAXIS1  =                   80", b"NAXIS1  =           8000000000"
    )
    path = tmp_path / "a.fits"
    path.write_bytes(data)
    with pytest.raises(NotKept):
        facts_of(path)


# ── hostile files: what it costs the hub ──


async def test_gzip_that_is_called_fits_is_refused_unopened(hub, files) -> None:
    # 200 MB in 200 kB: astropy unpacks such a file whole.
    header = fits_bytes()[:2880]
    packed = gzip.compress(header + bytes(200_000_000), 6)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    state = await upload(files, packed)
    assert "its first card is not SIMPLE" in state.refused
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 100_000
    assert [*hub.settings.data.glob("archive/**/*.fits")] == []


def test_pixels_are_bounded_by_their_bytes(tmp_path) -> None:
    path = tmp_path / "a.fits"
    # 12 000 × 12 000 of eight bytes each, which are claimed and not there.
    cards = {"BITPIX": "-64", "NAXIS1": "12000", "NAXIS2": "12000"}
    text = "".join(
        f"{key:8}= {cards.get(key, value):>20}".ljust(80)
        for key, value in (
            ("SIMPLE", "T"), ("BITPIX", "8"), ("NAXIS", "2"), ("NAXIS1", "1"), ("NAXIS2", "1"),
        )
    )  # fmt: skip
    path.write_bytes((text + "END").ljust(2880).encode() + bytes(2880))
    with pytest.raises(NotKept, match="bytes"):
        facts_of(path)


async def test_picture_that_takes_too_long_to_read_is_kept_marked_and_told(
    hub, files, tmp_path
) -> None:
    slow = Archive(hub.hub.core.database, LocalFolder(tmp_path), reader=FitsProcess(longest_s=0.0))
    data = fits_bytes(seed=77)
    path = tmp_path / "a.part"
    path.write_bytes(data)
    keeper = FitsArchiver(hub.hub.core.sites, slow, hub.hub.audit.log)
    await keeper("agv", offer_of(data), path)
    (kept,) = [*tmp_path.glob("archive/**/*.fits")]
    assert kept.read_bytes() == data
    admin = await hub.client("admin")
    found = (await admin.get("/api/audit", params={"kind": "picture not read"})).json()["rows"]
    assert [row["message"] for row in found] == [
        f"{kept.name}: not read: it takes longer than may be waited"
    ]


async def test_what_ends_the_reader_ends_not_the_hub_and_the_next_file_is_read(tmp_path) -> None:
    process = FitsProcess()
    good = tmp_path / "good.fits"
    good.write_bytes(fits_bytes())
    assert (await process.read_facts("agv", good)).target == "M 31"
    child = process._pipes._child
    assert child is not None
    limits = await asyncio.to_thread(Path(f"/proc/{child.pid}/limits").read_text)
    memory = next(line for line in limits.splitlines() if line.startswith("Max address space"))
    assert "unlimited" not in memory
    child.kill()
    child.wait()
    assert (await process.read_facts("other", good)).target == "M 31"
