"""Readers of files: pictures, recordings, films, tables and networks."""

from __future__ import annotations

import json
import tempfile
from contextlib import closing
from pathlib import Path

import pyarrow as pa
import pyarrow.ipc

from talaia.cli.errors import BadFile
from talaia.cli.importing.messages import Messages
from talaia.gateway.fits.header import NotFits, length_of, values_of
from talaia.gateway.recording.film_file import recover_film
from talaia.gateway.recording.mcap_file import recover_file
from talaia.hub.archive.fits_reader import NotKept, facts_of, looks_of, preview_of
from talaia.hub.history.errors import HistoryError
from talaia.hub.history.import_file import read_parcel
from talaia.hub.live.pictures.jpeg_decoder import Unreadable, decode_pixels
from talaia.hub.live.pictures.jpeg_validator import NotAPicture, bare_jpeg
from talaia.imaging.errors import UnreadableFrame
from talaia.imaging.fits_pixels import read_frame
from talaia.model.yaml_text.load import load_site
from talaia.objects.child import _load_network
from talaia.objects.errors import DetectorError

from .target import FuzzTarget

# In memory: each input is a file for a moment.
_FOLDER = tempfile.TemporaryDirectory(prefix="talaia-fuzz-", dir="/dev/shm")
_FILE = Path(_FOLDER.name) / "file"
_WHOLE = Path(_FOLDER.name) / "whole"


def _file_of(data: bytes) -> Path:
    _FILE.write_bytes(data)
    return _FILE


# What `talaia import` looks for in a recording.
_SITE = load_site(
    """
talaia: 1
site: a
name: A
connections: {ros: {kind: ros2}}
devices:
  a:
    name: A
    connection: ros
    signals: {x: {name: X, type: number, source: {topic: /a, type: a/msg/T, field: x}}}
"""
)


def _import_recording(data: bytes) -> None:
    with closing(Messages(_file_of(data), "MCAP", _SITE)) as messages:
        for _ in messages.read_pieces():
            pass


def _read_fits(data: bytes) -> None:
    """Read as the archive's child does; it has its own bound on memory."""
    path = _file_of(data)
    json.dumps(facts_of(path))
    json.dumps(looks_of(path))
    preview_of(path, "asinh", 64)


def _read_fits_header(data: bytes) -> None:
    if length_of(data) is not None:
        values_of(data)


def _read_parcel(data: bytes) -> None:
    _, chunks = read_parcel(_file_of(data))
    for _ in chunks:
        pass


def _read_arrow(data: bytes) -> None:
    reader = pa.ipc.open_stream(pa.BufferReader(data))
    for batch in reader:
        batch.validate(full=True)


def _read_network(data: bytes) -> None:
    job = {"file": str(_file_of(data)), "remedy": "", "kind": "nanodet", "side": 32}
    job |= {"mean": [0.0] * 3, "spread": [1.0] * 3, "blue_first": True, "classes": []}
    _load_network(job)


TARGETS = (
    FuzzTarget("fits", _read_fits, (NotKept, MemoryError), share=0.02),
    FuzzTarget("fits_pixels", read_frame, (UnreadableFrame,)),
    FuzzTarget("fits_header", _read_fits_header, (NotFits,)),
    FuzzTarget("small_jpeg", bare_jpeg, (NotAPicture,)),
    FuzzTarget("camera_jpeg", decode_pixels, (Unreadable,)),
    FuzzTarget(
        "recording",
        lambda data: recover_file(_file_of(data), _WHOLE),
        (OSError, ValueError),
        share=0.1,
    ),
    FuzzTarget("import", _import_recording, (BadFile,), share=0.1),
    FuzzTarget(
        "film", lambda data: recover_film(_file_of(data), _WHOLE), (OSError, ValueError), share=0.05
    ),
    FuzzTarget("parcel", _read_parcel, (HistoryError,), share=0.3),
    FuzzTarget("arrow", _read_arrow, (pa.ArrowException, OSError), share=0.2),
    FuzzTarget("network", _read_network, (DetectorError,), share=0.05),
)
