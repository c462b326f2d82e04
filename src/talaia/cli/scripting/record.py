"""``talaia record``: begin, end, list and fetch recordings."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.cli.scripting.hub_options import add_hub_options, hub_parser, open_client, quiet_pipe

if TYPE_CHECKING:
    import argparse
    from collections.abc import Sequence

    from talaia.client import Client, RecordedFile

__all__ = ["main"]


def main(argv: Sequence[str]) -> int:
    """Do what the word says."""
    parser = hub_parser(
        "record",
        "Begin or end a recording of a site's raw topics (MCAP) or the film of one camera (MP4),"
        " list what was recorded, and take it away.",
    )
    words = parser.add_subparsers(dest="word", required=True)
    for word, summary in (
        ("start", "begin, and print the recording's name"),
        ("stop", "end"),
        ("list", "what was recorded, the newest first"),
        ("fetch", "save one as a file, when the whole of it is at the hub"),
    ):
        added = words.add_parser(word, help=summary, description=summary)
        added.add_argument("site")
        if word in {"start", "stop"}:
            added.add_argument(
                "--camera", default="", metavar="DEVICE/STREAM", help="film this camera alone"
            )
        if word == "start":
            added.add_argument("--why", default="", help="for those who look at the list")
        if word == "fetch":
            added.add_argument("recording", help="its name, as the list has it; or newest")
            added.add_argument("-o", "--output", type=Path, metavar="FILE")
            added.add_argument(
                "--wait", type=float, default=600.0, metavar="SECONDS", help="default: 600"
            )
        added.add_argument("--json", action="store_true", help="print JSON")
        add_hub_options(added)
    options = parser.parse_args(argv)
    with quiet_pipe(), open_client(options) as client:
        _RUN[options.word](client, options)
    return 0


def _json_text(value: object) -> str:
    import msgspec

    return msgspec.json.encode(value).decode()


def _start_recording(client: Client, options: argparse.Namespace) -> None:
    recorder = client.start_recording(options.site, why=options.why, stream=options.camera)
    if options.json:
        print(_json_text(recorder))
    else:
        print(f"filming {options.camera}" if options.camera else recorder.id)


def _stop_recording(client: Client, options: argparse.Namespace) -> None:
    recorder = client.stop_recording(options.site, stream=options.camera)
    print(_json_text(recorder) if options.json else "ended")


def _list_recordings(client: Client, options: argparse.Namespace) -> None:
    from talaia.client.values import time_of

    overview = client.list_recordings(options.site)
    if options.json:
        print(_json_text(overview))
        return
    if overview.recorder.on:
        print(f"{overview.recorder.id}  is being recorded: {overview.recorder.why}")
    for found in overview.recordings:
        began = time_of(found.begin_us).strftime("%Y-%m-%dT%H:%M:%SZ")
        what = found.stream or f"{len(found.topics)} topics"
        said = " ".join(filter(None, (found.why, found.note)))
        print(f"{found.id}  {began}  {found.state:<10} {found.size:>12}  {what}  {said}".rstrip())


def _fetch_recording(client: Client, options: argparse.Namespace) -> None:
    name = options.recording
    if name == "newest":
        listed = client.list_recordings(options.site).recordings
        name = listed[0].id if listed else name
    found = client.wait_recording(options.site, name, timeout_s=options.wait)
    path = options.output or Path(_file_name(options.site, found))

    def show_progress(written: int) -> None:
        share = written / found.size if found.size else 1.0
        print(f"\r{path}: {share:.0%}", end="", file=sys.stderr, flush=True)

    # A bar is for people: a log would keep each of its steps.
    report = show_progress if sys.stderr.isatty() else None
    size = client.download_recording(options.site, name, path, report=report)
    if report is not None:
        print(file=sys.stderr)
    if options.json:
        print(_json_text({"file": str(path), "size": size}))
    else:
        print(f"{path}: {size} bytes")


def _file_name(site: str, found: RecordedFile) -> str:
    # The hub's names hold no slash; a file is never written elsewhere by what it says.
    name = f"{site}-{found.id}.{'mp4' if found.stream else 'mcap'}"
    return name.replace("/", "-")


_RUN = {
    "start": _start_recording,
    "stop": _stop_recording,
    "list": _list_recordings,
    "fetch": _fetch_recording,
}
