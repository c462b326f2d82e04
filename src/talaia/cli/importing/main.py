"""``talaia import``: read files, say what is in them, and bring it into a site's history."""

from __future__ import annotations

import contextlib
import datetime as dt
import hashlib
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

from talaia.cli.errors import BadFile, CliError
from talaia.cli.importing.delivery import deliver_parcels, known_description
from talaia.cli.importing.extension_source import ExtensionImportSource, importer_of
from talaia.cli.importing.messages import Messages
from talaia.cli.importing.staging import Staging
from talaia.cli.importing.table import Table
from talaia.cli.importing.times import TimeReader, TimeUnit
from talaia.hub.history.import_file import FOLDER, Head, ParcelWriter, remove_abandoned
from talaia.hub.settings import Settings
from talaia.model.checks.site_checks import raise_first
from talaia.model.yaml_text.load import dump_site, load_site, read_site

if TYPE_CHECKING:
    import argparse
    from collections.abc import Iterator, Sequence

    from talaia.cli.importing.source import Findings, ImportSource
    from talaia.cli.importing.staging import Tally
    from talaia.hub.live.files.import_inbox import ImportResult
    from talaia.model.site import Site

__all__ = ["import_files"]

_DAY_US = 86_400_000_000  # Of `keep`, which counts days.
_TELL_S = 5.0  # Seconds between two words of progress.
_MOST_SAID = 40  # Rows of a list; a bag may hold hundreds of topics.
_EXTENSION = "extension "


class _Read(NamedTuple):
    path: Path
    tallies: list[Tally]
    findings: Findings


def import_files(options: argparse.Namespace) -> int:
    """Import each file, or none of them; give the exit code.

    Args:
        options: as `talaia.cli.importing.command_line` reads them.

    """
    settings = Settings(
        data=options.data,
        database_url=Settings.url_from(),
        history_servers=options.history_servers,
    )
    site = _load_site(options.site, settings)
    named = _named_columns(options.column)
    reads: list[_Read] = []
    folder = settings.data / FOLDER
    if not options.dry_run:
        _check_data(settings.data)
        remove_abandoned(
            folder
        )  # What a killed import left behind, before this one needs the room.
    with contextlib.ExitStack() as stack:
        writers: list[ParcelWriter] = []
        for path in options.file:
            times = TimeReader(_time_zone(options.zone), TimeUnit(options.time_unit))
            with contextlib.closing(
                _open_source(path, site, named=named, time_column=options.time, times=times)
            ) as source:
                writer = None
                if not options.dry_run:
                    head = Head(
                        site=site.site,
                        file=path.name[:200],
                        digest=_digest_file(path),
                        description=dump_site(site),
                    )
                    writer = stack.enter_context(_make_writer(folder, head))
                    writers.append(writer)
                reads.append(_Read(path, _read_file(path, source, site, writer), source.findings))
            _print_summary(site, reads[-1], source.kind)
        if options.dry_run:
            print("nothing was written (--dry-run)")
            return 0
        # Only now that all of them are read; until here nothing has happened.
        ready = [writer.publish_file() for writer in writers]
    for read, how in zip(reads, deliver_parcels(settings, ready, _print_progress), strict=True):
        print(f"{read.path}: {_result_text(how)}")
    return 0


def _check_data(data: Path) -> None:
    if not data.is_dir():
        raise CliError(
            f"there is no data folder {data}; name the hub's with --data, or start the hub once"
        )


def _load_site(asked: str, settings: Settings) -> Site:
    path = Path(asked)
    if path.suffix in (".yaml", ".yml") or path.is_file():
        return raise_first(read_site(path))
    _check_data(settings.data)
    text = known_description(settings, asked)
    if text is None:
        raise CliError(f"the hub knows no site {asked!r}; name the file of its description instead")
    return load_site(text)


def _named_columns(columns: Sequence[str]) -> dict[str, str]:
    named = {}
    for column in columns:
        heading, found, address = column.rpartition("=")
        if not found or not heading or not address:
            raise CliError(f"--column {column}: expected HEADING=ADDRESS, as temp=dome/temperature")
        named[heading] = address
    return named


def _time_zone(name: str) -> ZoneInfo | None:
    if not name:
        return None
    try:
        return ZoneInfo(name)
    except (ZoneInfoNotFoundError, ValueError, OSError) as error:
        raise CliError(f"--zone {name}: no such time zone; write it as Europe/Madrid") from error


def _file_kind(path: Path) -> str:
    """Tell what a file is by how it begins."""
    try:
        if path.is_dir():
            if (path / "metadata.yaml").is_file():
                return "rosbag 2"
            raise BadFile(
                str(path),
                "",
                "a folder without metadata.yaml is no rosbag 2",
                "`ros2 bag reindex` makes it anew",
            )
        with path.open("rb") as file:
            start = file.read(16)  # As long as SQLite's, the longest signature.
    except OSError as error:
        raise BadFile(str(path), "", f"it cannot be opened: {error.strerror}") from error
    if start.startswith(b"#ROSBAG"):
        return "rosbag 1"
    if start.startswith(b"\x89MCAP"):
        return "MCAP"
    if start.startswith(b"SQLite format 3"):
        return "rosbag 2"
    if not start:
        raise BadFile(str(path), "", "it is empty")
    if name := importer_of(path):
        return f"{_EXTENSION}{name}"
    if b"\0" in start or path.suffix.lower() in (".bag", ".mcap", ".db3"):
        raise BadFile(str(path), "byte 0", "its format is none of rosbag 1, rosbag 2, MCAP and CSV")
    return "CSV"


def _open_source(
    path: Path, site: Site, *, named: dict[str, str], time_column: str, times: TimeReader
) -> ImportSource:
    kind = _file_kind(path)
    if kind == "CSV":
        return Table(path, site, named=named, time_column=time_column, times=times)
    if kind.startswith(_EXTENSION):
        return ExtensionImportSource(path, kind.removeprefix(_EXTENSION), site, named)
    return Messages(path, kind, site)


def _digest_file(path: Path) -> str:
    """Give the SHA-256 of a file, or of a folder's files with their names."""
    total = hashlib.sha256()
    for file in sorted(path.iterdir()) if path.is_dir() else [path]:
        if path.is_dir():
            total.update(f"{file.name}\n".encode())  # So that two files swapped are another folder.
        if file.is_file():
            with file.open("rb") as opened:
                total.update(hashlib.file_digest(opened, "sha256").digest())
    return total.hexdigest()


@contextlib.contextmanager
def _make_writer(folder: Path, head: Head) -> Iterator[ParcelWriter]:
    try:
        with ParcelWriter(folder, head) as writer:
            yield writer
    except OSError as error:
        raise CliError(f"{folder} cannot be written: {error}; nothing was imported") from error


def _read_file(
    path: Path, source: ImportSource, site: Site, writer: ParcelWriter | None
) -> list[Tally]:
    staging = Staging([channel.address for channel in site.channels()], writer)
    told = time.monotonic()  # Monotonic, or a clock that is set would silence the progress.
    for piece in source.read_pieces():
        staging.add_samples(piece.columns)
        if time.monotonic() - told > _TELL_S:
            told = time.monotonic()
            _print_progress(f"{path}: {piece.done:.0%} read, {staging.samples:,} samples")
    staging.finish_files()
    tallies = staging.channel_tallies()
    signals = {tally.address for tally in tallies}
    for channel in site.channels():
        if channel.address not in signals:
            source.findings.absent.setdefault(channel.address, "no message in the file holds it")
    return tallies


def _print_summary(site: Site, read: _Read, kind: str) -> None:
    print(f"{read.path} ({kind})")
    width = max((len(tally.address) for tally in read.tallies), default=0)
    for tally in read.tallies:
        span = f"{_time_text(tally.first_us)} to {_time_text(tally.last_us)}"
        print(f"  {tally.address:<{width}}  {tally.samples:>12,} samples  {span}")
    if not read.tallies:
        print("  nothing in it belongs to this site")
    _print_list("not in the file", read.findings.absent)
    _print_list("not read", read.findings.unread)
    notes = [*read.findings.notes, *_retention_warnings(site, read.tallies)]
    for note in notes:
        print(f"  note: {note}")


def _print_list(title: str, reasons: dict[str, str]) -> None:
    for at, (name, reason) in enumerate(reasons.items()):
        if at == _MOST_SAID:
            print(f"  {title}: {len(reasons) - at} more")
            return
        print(f"  {title}: {name}" + (f" ({reason})" if reason else ""))


def _retention_warnings(site: Site, tallies: Sequence[Tally]) -> Iterator[str]:
    now_us = time.time_ns() // 1000
    channels = {channel.address: channel for channel in site.channels()}
    for tally in tallies:
        channel = channels[tally.address]
        keep = site.devices[channel.device].signals[channel.signal].keep
        if keep > 0 and tally.last_us < now_us - keep * _DAY_US:
            yield f"{tally.address} is kept for {keep:g} days only, and will be dropped soon"


def _time_text(time_us: int) -> str:
    try:
        moment = dt.datetime.fromtimestamp(time_us // 1_000_000, dt.UTC)
    except (ValueError, OverflowError, OSError):
        return f"{time_us} µs"
    return f"{moment:%Y-%m-%d %H:%M:%S}Z"


def _result_text(how: ImportResult) -> str:
    if not how.stored:
        return f"all of its {how.there:,} samples were there already"
    there = f", {how.there:,} were there already" if how.there else ""
    return f"{how.stored:,} samples are in the history now{there}"


def _print_progress(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
