"""What becomes of a new picture: measured and solved, handed over, exported for archives."""

from __future__ import annotations

import asyncio
import csv
import hashlib
import io
import json
import stat
import sys
import warnings
from contextlib import asynccontextmanager
from functools import lru_cache
from ipaddress import ip_network
from pathlib import Path

import numpy as np
import pytest
from astropy.io import fits
from astropy.io.votable import parse, validate
from astropy.wcs import WCS
from patience import PATIENCE_S
from pyvo.dam.obscore import ObsCoreMetadata

from talaia.hub.archive.frame_measurer import FrameMeasurer
from talaia.hub.archive.frame_queues import FrameQueues
from talaia.hub.archive.frame_rows import ArchivedFrame, FrameMeasures, MeasureState, Wanted
from talaia.hub.archive.hook import ArchiveHook, HookCommand, HookPost
from talaia.hub.archive.hook_settings import ArchiveHookSettings, read_archive_hook
from talaia.hub.archive.obscore import (
    ObscoreContext,
    obscore_row,
    write_csv,
    write_votable,
)
from talaia.hub.archive.obscore_columns import COLUMNS
from talaia.hub.archive.store import Archive
from talaia.hub.errors import CannotStart
from talaia.hub.files.local_folder import LocalFolder
from talaia.hub.notify.senders import Sender
from talaia.hub.observing.frame_assignment import ObservationSpan, assign_frames
from talaia.hub.store.database import Database
from talaia.imaging.tangent_plane import angular_distance
from talaia.sim.observatory.models.fits import fits_file
from talaia.sim.observatory.models.sky_picture import Chip, Shot, draw_picture
from talaia.wire.frames import ArchiveOffer

CHIP = Chip()
PLACE = (83.8, -5.4)
FRAME = ArchivedFrame(
    id=7, site="observatory", device="camera", night="2026-11-20", name="m42.fits",
    time_us=1_795_228_200_000_000, target="M 42 <'&>", filter="R", kind="Light", exposure_s=60.0,
    ra_deg=83.8, dec_deg=-5.4, width=765, height=510, bytes=800_000, digest="d" * 64, problems=(),
    measures=FrameMeasures(
        MeasureState.MEASURED, 31, 2.6, 410.0, 21.5, (83.8, -5.4, 382.0, 254.5, -3e-4, 0, 0, 3e-4)
    ),
)  # fmt: skip


@lru_cache(maxsize=1)
def sky_file() -> bytes:
    """A picture of the simulator's sky, whose mount is off by minutes of arc."""
    cards = [
        ("OBJECT", "M 42", ""), ("IMAGETYP", "Light", ""), ("EXPTIME", 10.0, ""),
        ("DATE-OBS", "2026-11-21T02:30:00", ""), ("RA", PLACE[0] + 0.05, ""),
        ("DEC", PLACE[1] + 0.04, ""), ("XPIXSZ", CHIP.pixel_um, ""),
        ("FOCALLEN", CHIP.focal_mm, ""), ("CTYPE1", "RA---TAN", "an estimate"),
        ("CDELT1", 1.0, ""), ("CROTA2", 33.0, ""),
    ]  # fmt: skip
    return fits_file(draw_picture(Shot(*PLACE, 10.0, seeing=2.6), CHIP), cards)


@pytest.fixture
async def database(tmp_path):
    """A database that no hub runs on: a hub measures what waits in its own, and so would two."""
    made = Database(f"sqlite+aiosqlite:///{tmp_path}/talaia.db")
    await made.migrate()
    yield made
    await made.close()


@pytest.fixture
def archived(database, tmp_path):
    """Put a file into an archive of its own."""
    archive = Archive(database, LocalFolder(tmp_path), hooked=True)

    async def put(data: bytes, name: str = "0" * 32) -> ArchivedFrame:
        path = tmp_path / "came.part"
        path.write_bytes(data)
        digest = hashlib.sha256(data + name.encode()).hexdigest()
        offer = ArchiveOffer(
            id=name, kind="fits", device="camera", size=len(data), digest=digest, time_us=1
        )
        return await archive.archive_file("alone", "UTC", offer, path)

    put.archive = archive
    put.queues = FrameQueues(database, archive)
    return put


@asynccontextmanager
async def running(task):
    """Run a task until the end of the block."""
    under_way = asyncio.create_task(task)
    try:
        yield
    finally:
        under_way.cancel()
        await asyncio.gather(under_way, return_exceptions=True)


async def found(archive: Archive) -> list[ArchivedFrame]:
    return (await archive.find_frames("alone", ["camera"], Wanted(), 10))[0]


async def test_a_new_picture_gets_its_place_and_quality_and_keeps_its_pixels(archived) -> None:
    kept = await archived(sky_file())
    async with running(FrameMeasurer(archived.queues).run()), asyncio.timeout(PATIENCE_S):
        await archived.queues.measured.wait()
    (frame,) = await found(archived.archive)
    measures = frame.measures
    assert (measures.state, measures.note) == (MeasureState.MEASURED, "")
    assert angular_distance(frame.ra_deg, frame.dec_deg, *PLACE) * 3600 < 2.0
    assert measures.stars > 10
    assert measures.fwhm == pytest.approx(2.6, rel=0.3)
    assert measures.zero_point == pytest.approx(20.97, abs=0.1)
    path = archived.archive.files.find_local(archived.archive.frame_key(frame))
    assert frame.bytes == path.stat().st_size
    with (
        fits.open(path) as hdus,
        fits.open(io.BytesIO(sky_file())) as before,
        warnings.catch_warnings(action="ignore"),
    ):
        hdus.verify("exception")
        assert np.array_equal(hdus[0].data, before[0].data)
        # A foreign reader of the cards finds the middle where it is.
        middle = WCS(hdus[0].header).pixel_to_world((CHIP.width - 1) / 2, (CHIP.height - 1) / 2)
        assert angular_distance(middle.ra.deg, middle.dec.deg, *PLACE) * 3600 < 2.0
        assert hdus[0].header["NSTARS"] == measures.stars
        assert hdus[0].header["OBJECT"] == "M 42"
    assert kept.digest == frame.digest


async def test_a_picture_that_takes_too_long_of_a_processor_is_left_and_the_next_one_measured(
    archived,
) -> None:
    await archived(sky_file())
    # Less than to import what measures.
    async with (
        running(FrameMeasurer(archived.queues, most_s=0.01).run()),
        asyncio.timeout(PATIENCE_S),
    ):
        await archived.queues.measured.wait()
        archived.queues.measured.clear()
        await archived(picture_of("next"), "1" * 32)
        await archived.queues.measured.wait()
    frames = await found(archived.archive)
    assert {frame.measures.state for frame in frames} == {MeasureState.MEASURED}
    assert {frame.measures.note for frame in frames} == {
        "it could not be measured within 0.01 s of a processor"
    }


class Taker:
    """Takes pictures as a hook does; refuses so many tries."""

    def __init__(self, refusals: int = 0) -> None:  # noqa: D107
        self.names, self.refusals, self.took = [], refusals, asyncio.Condition()

    async def hand_over(self, document) -> str:
        self.names.append(document["target"])
        self.refusals -= 1
        async with self.took:
            self.took.notify_all()
        return "not now" if self.refusals >= 0 else ""

    async def wait_for(self, name: str) -> None:
        async with asyncio.timeout(PATIENCE_S), self.took:
            await self.took.wait_for(lambda: name in self.names)


class Notes:
    """An audit log in memory."""

    def __init__(self) -> None:  # noqa: D107
        self.kinds = []

    def append_record(self, kind, **_about) -> None:
        self.kinds.append(kind)


def picture_of(target: str) -> bytes:
    counts = np.full((20, 20), 100, np.uint16)
    return fits_file(counts, [("OBJECT", target, ""), ("IMAGETYP", "Bias", "")])


async def measure_all(archived) -> None:
    from talaia.hub.archive.measure_child import MeasuredFile

    while (frame := await archived.queues.next_unmeasured()) is not None:
        await archived.queues.keep_measures(frame, MeasuredFile())


async def test_every_picture_is_handed_over_in_order_also_after_a_restart_and_refusals(
    archived,
) -> None:
    for target in ("one", "two", "three"):
        await archived(picture_of(target), target.ljust(32, "0"))
    await measure_all(archived)
    # A hub that was killed while it handed over the second one.
    first = await archived.queues.next_for_hook()
    await archived.queues.mark_handed_over(first)
    taker, notes = Taker(refusals=2), Notes()
    async with running(ArchiveHook(archived.queues, taker, notes, (0.0,)).run()):
        await taker.wait_for("three")
        await archived(picture_of("four"), "4" * 32)
        await measure_all(archived)
        await taker.wait_for("four")
    assert taker.names == ["two", "two", "two", "three", "four"]
    # One line for each trouble, not for each try.
    assert notes.kinds == ["picture not handed over", "picture handed over"]


async def test_a_picture_that_is_still_measured_holds_up_those_behind_it(archived) -> None:
    await archived(picture_of("one"))
    assert await archived.queues.next_for_hook() is None


async def test_a_command_gets_the_facts_on_its_input_and_none_of_our_secrets(
    tmp_path, monkeypatch
) -> None:
    monkeypatch.setenv("TALAIA_DATABASE_URL", "secret")
    program = tmp_path / "hook"
    program.write_text(
        f"#!{sys.executable}\nimport json, os, sys\n"
        "said = json.load(sys.stdin)\n"
        "out = [said['target'], sys.argv[1:], 'TALAIA_DATABASE_URL' in os.environ]\n"
        "open('out', 'w').write(json.dumps(out))\n"
        "sys.exit(said['target'] == 'bad')\n"
    )
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    hook = HookCommand(ArchiveHookSettings(command=[str(program), "an argument"]), tmp_path)
    hostile = "; touch /tmp/x $(id)"
    assert await hook.hand_over({"target": hostile}) == ""
    assert json.loads((tmp_path / "out").read_text()) == [hostile, ["an argument"], False]
    assert "ended with 1" in await hook.hand_over({"target": "bad"})
    slow = ArchiveHookSettings(command=["/bin/sleep", "60"], timeout=0.1)
    assert "no end after 0.1 s" in await HookCommand(slow, tmp_path).hand_over({})


async def test_a_webhook_gets_them_only_where_messages_may_go(tmp_path) -> None:
    heard = []

    async def answer(reader, writer) -> None:
        head = await reader.readuntil(b"\r\n\r\n")
        size = int(head.lower().split(b"content-length:")[1].split()[0])
        heard.append((head.decode(), json.loads(await reader.readexactly(size))))
        writer.write(b"HTTP/1.1 204 No Content\r\nConnection: close\r\n\r\n")
        writer.close()

    server = await asyncio.start_server(answer, "127.0.0.1", 0)
    port = server.sockets[0].getsockname()[1]
    (tmp_path / "token").write_text("abc\n")
    url = f"http://127.0.0.1:{port}/new"
    told = ArchiveHookSettings(url=url, token_file=str(tmp_path / "token"))
    async with server:
        problem = await HookPost(told, Sender(())).hand_over({"id": "7"})
        assert "no public address" in problem
        assert heard == []
        meant = Sender((ip_network("127.0.0.0/8"),))
        assert await HookPost(told, meant).hand_over({"id": "7", "target": "M 42"}) == ""
    ((head, body),) = heard
    assert body == {"id": "7", "target": "M 42"}
    assert "Authorization: Bearer abc" in head
    assert "Idempotency-Key: frame-7" in head


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("{}", "either a command or a url"),
        ("command: [/bin/true]\nurl: https://a.example/", "either a command or a url"),
        ("command: /bin/true -x", "Expected `array`"),
        ("command: [echo]", "whole path of a program"),
        ("url: file:///etc/passwd", "https:// or http://"),
        ("commnd: [/bin/true]", "commnd"),
    ],
)
def test_a_hook_that_names_no_program_by_its_path_keeps_the_hub_from_starting(
    tmp_path, text: str, why: str
) -> None:
    path = tmp_path / "hook.yaml"
    path.write_text(text)
    with pytest.raises(CannotStart, match=why):
        read_archive_hook(path)


def test_the_table_is_one_of_obscore_for_a_foreign_reader(tmp_path: Path) -> None:
    bare = FRAME._replace(id=8, measures=FrameMeasures(), exposure_s=float("nan"), filter="")
    context = ObscoreContext("https://hub.example", "STARS-1")
    rows = [obscore_row(frame, context) for frame in (FRAME, bare)]
    text = "".join(write_votable(rows, "observatory"))
    path = tmp_path / "t.vot"
    path.write_text(text)
    with warnings.catch_warnings():
        # What departs from VOTable 1.4 is a warning there.
        warnings.simplefilter("error")
        table = parse(path, verify="exception").get_first_table()
    assert validate(str(path), output=None)
    read = table.to_table()
    # By the names that PyVO knows: the 30 that every service has to have.
    assert set(read.colnames[:30]) <= vars(ObsCoreMetadata()).keys()
    assert read["target_name"][0] == "M 42 <'&>"
    assert read["proposal_id"][0] == "STARS-1"
    assert read["t_min"][0] == pytest.approx(61365.10417, abs=1e-4)
    assert read["t_max"][0] - read["t_min"][0] == pytest.approx(60 / 86400)
    assert (read["em_min"][0], read["em_max"][0]) == pytest.approx((589e-9, 727e-9))
    # The diagonal of 765 by 510 pixels of 0.0003°.
    assert read["s_fov"][0] == pytest.approx(0.0003 * np.hypot(765, 510), rel=1e-3)
    assert read["s_region"][0].startswith("POLYGON ICRS ")
    assert [bool(read[name].mask[1]) for name in ("s_fov", "em_min", "t_exptime")] == [True] * 3
    lines = list(csv.DictReader(io.StringIO("".join(write_csv(rows)))))
    assert list(lines[0]) == [column.name for column in COLUMNS]
    assert lines[0]["access_url"] == "https://hub.example/api/sites/observatory/frames/7/file"
    assert lines[1]["s_fov"] == ""


def test_a_name_that_a_spreadsheet_would_run_is_only_a_text() -> None:
    row = obscore_row(FRAME._replace(target="=cmd|' /C calc'!A0"), ObscoreContext(""))
    assert "'=cmd" in "".join(write_csv([row]))
    control = obscore_row(FRAME._replace(target="a\x00b"), ObscoreContext(""))
    assert "\x00" not in "".join(write_votable([control], "s"))


def test_pictures_belong_to_the_observation_under_way_of_the_same_target() -> None:
    rained = ObservationSpan("a", 1, "P", "M 42", 0, 100_000_000)
    between = ObservationSpan("b", 2, "Q", "M 42", 40_000_000, 60_000_000)
    goes_on = ObservationSpan("c", 3, "P", "Große Wolke", 120_000_000, None)
    frames = [
        FRAME._replace(id=number, time_us=seconds * 1_000_000, target=target)
        for number, (seconds, target) in enumerate(
            [
                (10, "M 42"), (50, "M 42"), (80, "M 42"), (110, "M 42"), (50, "focus or centring"),
                (500, "Gro?e Wolke"), (500, ""),
            ]
        )
    ]  # fmt: skip
    known = assign_frames(frames, [rained, between, goes_on])
    assert {frame: span.id for frame, span in known.items()} == {
        0: "a", 1: "b", 2: "a", 5: "c", 6: "c",
    }  # fmt: skip
