"""FITS files that come whole: kept once, with site and camera in the header."""

from __future__ import annotations

import io
import warnings
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from astropy.io import fits

from talaia.clock import SystemClock
from talaia.gateway.adapters.topic_readers import file_in
from talaia.gateway.errors import FieldError
from talaia.gateway.fits.outbox import ArchiveOutbox
from talaia.gateway.fits.whole_files import MOST_WAITING, WholeFiles
from talaia.model.interlocks.enclosure import Place

if TYPE_CHECKING:
    from pathlib import Path

PLACE = Place(latitude=28.3, longitude=-16.5, elevation=2390)


class Told:
    def __init__(self) -> None:  # noqa: D107
        self.problems: list[str] = []

    def report_event(self, kind: str, message: str, **_more: object) -> None:
        assert kind == "picture_lost"
        self.problems.append(message)


def picture(number: int = 0, **cards: object) -> bytes:
    hdu = fits.PrimaryHDU(np.full((3, 4), number, np.int16))
    for key, value in cards.items():
        hdu.header[key] = value
    out = io.BytesIO()
    hdu.writeto(out)
    return out.getvalue()


def taken(folder: Path, *files: bytes) -> Told:
    """Let a gateway that has just begun take these files, and wait until it has."""
    told, disk = Told(), ThreadPoolExecutor(1)
    outbox = ArchiveOutbox(folder / "outbox", 10**9, lambda: None)
    sink = WholeFiles(
        folder=folder / "taking",
        outbox=outbox,
        events=told,
        clock=SystemClock(),
        disk=disk,
        site="Izaña",
        place=PLACE,
    )
    for data in files:
        sink.keep_file("camera", lambda data=data: data)
        disk.submit(lambda: None).result()
    disk.shutdown()
    return told


def waiting(folder: Path) -> list[bytes]:
    return [path.read_bytes() for path in sorted((folder / "outbox").glob("*.bin"))]


def test_a_file_that_comes_again_is_kept_once_also_after_a_restart(tmp_path: Path) -> None:
    taken(tmp_path, picture(1), picture(1), picture(2))
    assert len(waiting(tmp_path)) == 2
    taken(tmp_path, picture(2), picture(3))
    assert len(waiting(tmp_path)) == 3


def test_without_its_memory_a_file_becomes_the_same_bytes_so_that_the_hub_knows_it(
    tmp_path: Path,
) -> None:
    taken(tmp_path, picture(1))
    (tmp_path / "taking" / "seen.json").write_text("damaged")
    assert taken(tmp_path, picture(1)).problems == []
    first, second = waiting(tmp_path)
    assert first == second


def test_the_header_gets_site_and_camera_and_keeps_what_the_camera_wrote(tmp_path: Path) -> None:
    # Some programs leave the last block short.
    data = picture(7, OBJECT="M 31", SITEELEV=20.0, INSTRUME="ST-7")
    assert taken(tmp_path, data[: 2880 + 24]).problems == []
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with fits.open(io.BytesIO(waiting(tmp_path)[0])) as hdus:
            hdus.verify("exception")
            header = hdus[0].header
            assert (hdus[0].data == 7).all()
    assert (header["OBJECT"], header["SITEELEV"], header["INSTRUME"]) == ("M 31", 20.0, "ST-7")
    assert (header["SITELAT"], header["SITELONG"], header["TALAIADV"]) == (28.3, -16.5, "camera")
    assert (header["ORIGIN"], header["OBSERVAT"]) == ("Talaia", "Iza?a")


def test_a_place_that_the_camera_wrote_is_not_mixed_with_the_sites(tmp_path: Path) -> None:
    taken(tmp_path, picture(SITELAT=41.0))
    header = fits.getheader(io.BytesIO(waiting(tmp_path)[0]))
    assert header["SITELAT"] == 41.0
    assert "SITELONG" not in header


def test_what_is_no_fits_is_told_once_until_a_picture_comes(tmp_path: Path) -> None:
    told = taken(tmp_path, b"JPEG" * 9, b"PNG" * 9, picture()[:800], picture(), b"JPEG" * 9)
    assert len(told.problems) == 3
    assert "does not begin with SIMPLE" in told.problems[0]
    assert "ends in its header" in told.problems[1]
    assert len(waiting(tmp_path)) == 1
    assert list((tmp_path / "taking").iterdir()) == [tmp_path / "taking" / "seen.json"]


def test_no_more_files_wait_in_memory_than_a_few(tmp_path: Path) -> None:
    told, disk = Told(), ThreadPoolExecutor(1)
    outbox = ArchiveOutbox(tmp_path / "outbox", 10**9, lambda: None)
    sink = WholeFiles(
        folder=tmp_path / "taking",
        outbox=outbox,
        events=told,
        clock=SystemClock(),
        disk=disk,
        site="Izaña",
        place=None,
    )
    with outbox._turn:
        for number in range(MOST_WAITING + 1):
            sink.keep_file("camera", lambda number=number: picture(number))
        assert told.problems == ["the gateway's disk is too slow for it"]
    disk.shutdown()
    assert len(waiting(tmp_path)) == MOST_WAITING


def test_the_file_of_a_message_begins_at_its_offset_and_a_list_is_none() -> None:
    def message(data: object, offset: int = 0) -> object:
        return SimpleNamespace(data=data, layout=SimpleNamespace(data_offset=offset))

    assert file_in(message(np.frombuffer(b"SIMPLE", np.uint8))) == b"SIMPLE"
    assert file_in(message(b"..SIMPLE", 2)) == b"SIMPLE"
    with pytest.raises(FieldError, match="not a file"):
        file_in(message([1.5]))
