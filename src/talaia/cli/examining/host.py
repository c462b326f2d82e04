"""Whether this machine is fit for a hub or a gateway: programs, port, clock, disk, certificate."""

from __future__ import annotations

import ctypes
import datetime as dt
import errno
import os
import shutil
import socket
import sys
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from talaia.cli.examining.findings import PartFinding, PartState

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["RunningProgram", "examine_host", "running_programs"]

# What runs for long, as its second word.
_PROGRAMS = frozenset({"hub", "gateway", "demo", "demo-indi", "up", "sim"})
# With less (bytes, share of the disk) the history and recordings soon lose something.
_LEAST_FREE, _LEAST_SHARE = 2 * 10**9, 0.05
# A certificate of our own is renewed so long before its end (days); it should never be nearer.
_SOON_DAYS = 14
# adjtimex(2): its structure with room to spare, and where it says that nothing sets the clock.
_TIMEX_BYTES, _STATUS_AT, _UNSYNCHRONIZED = 512, 40, 0x40


class RunningProgram(NamedTuple):
    """A program of Talaia's that runs here."""

    pid: int
    words: tuple[str, ...]


def examine_host(data: Path, port: int) -> Iterator[PartFinding]:
    """Look at what runs, and at what a hub with this data folder and port needs."""
    programs = running_programs()
    for program in programs:
        said = f"{' '.join(program.words)[:80]} (process {program.pid})"
        yield PartFinding(PartState.OK, "running", said)
    if not programs:
        yield PartFinding(PartState.ABSENT, "running", "no hub and no gateway")
    yield _examine_port(port, hub_runs=any(program.words[:1] == ("hub",) for program in programs))
    yield _examine_clock()
    yield _examine_disk(data)
    yield from _examine_certificate(data / "tls" / "cert.pem")


def running_programs(proc: Path = Path("/proc")) -> list[RunningProgram]:
    """List Talaia's programs among all processes; none where ``/proc`` is not there."""
    found = []
    for folder in sorted(proc.glob("[0-9]*")):
        try:
            words = (folder / "cmdline").read_bytes().decode(errors="replace").split("\0")
        # It has ended, or is another user's.
        except OSError:
            continue
        places = [at for at, word in enumerate(words[:4]) if Path(word).name == "talaia"]
        if places and words[places[0] + 1 :][:1] and words[places[0] + 1] in _PROGRAMS:
            own = tuple(word for word in words[places[0] + 1 :] if word)
            found.append(RunningProgram(int(folder.name), own))
    return found


def _examine_port(port: int, *, hub_runs: bool) -> PartFinding:
    what = f"port {port}"
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe:
        # As the hub itself does: a port of connections that are just ending is free.
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", port))
        except OSError as error:
            if error.errno != errno.EADDRINUSE:
                remedy = "take a port from 1024 on with --port"
                return PartFinding(PartState.PROBLEM, what, str(error.strerror), remedy)
            if hub_runs:
                return PartFinding(PartState.OK, what, "taken, and a hub runs")
            remedy = "end that program, or start the hub with another --port"
            return PartFinding(PartState.PROBLEM, what, "taken by another program", remedy)
    return PartFinding(PartState.OK, what, "free")


def _examine_clock() -> PartFinding:
    now = dt.datetime.now(dt.UTC).strftime("%Y-%m-%d %H:%M:%S UTC")
    if not sys.platform.startswith("linux"):
        return PartFinding(PartState.ABSENT, "clock", f"{now}; whether it is set is not known")
    told = ctypes.create_string_buffer(_TIMEX_BYTES)
    # Modes of zero: it asks, and sets nothing.
    ctypes.CDLL(None).adjtimex(told)
    status = int.from_bytes(told.raw[_STATUS_AT : _STATUS_AT + 4], sys.byteorder)
    if status & _UNSYNCHRONIZED:
        remedy = "switch on a service that sets it (systemd-timesyncd or chrony)"
        detail = f"{now}; the kernel does not know of anything that sets it"
        return PartFinding(PartState.ABSENT, "clock", detail, remedy)
    return PartFinding(PartState.OK, "clock", f"{now}, synchronized")


def _examine_disk(data: Path) -> PartFinding:
    place = data.absolute()
    # A folder that the hub will make lies on the disk of the nearest one that is there.
    while not place.exists():
        place = place.parent
    usage = shutil.disk_usage(place)
    detail = f"{usage.free / 1e9:.1f} of {usage.total / 1e9:.1f} GB are free at {place}"
    if not os.access(place, os.W_OK):
        remedy = "choose another folder with --data, or run as its owner"
        return PartFinding(PartState.PROBLEM, "disk", f"{place} cannot be written", remedy)
    if usage.free < max(_LEAST_FREE, _LEAST_SHARE * usage.total):
        remedy = "make room, or bound the history with --history-gb"
        return PartFinding(PartState.PROBLEM, "disk", detail, remedy)
    return PartFinding(PartState.OK, "disk", detail)


def _examine_certificate(path: Path) -> Iterator[PartFinding]:
    if not path.is_file():
        detail = f"none in {path.parent}; the hub makes one at its first start"
        yield PartFinding(PartState.ABSENT, "certificate", detail)
        return
    try:
        from cryptography import x509

        end = x509.load_pem_x509_certificate(path.read_bytes()).not_valid_after_utc
    except ModuleNotFoundError:
        yield PartFinding(PartState.ABSENT, "certificate", f"{path} cannot be read without the hub")
    except (OSError, ValueError) as error:
        remedy = "remove it with its key, and the hub makes both anew; gateways are enrolled again"
        yield PartFinding(PartState.PROBLEM, "certificate", f"{path}: {error}", remedy)
    else:
        left = (end - dt.datetime.now(dt.UTC)).days
        detail = f"{path}, good for {left} days"
        soon = left < _SOON_DAYS
        remedy = "start the hub: it renews its own certificate" if soon else ""
        yield PartFinding(
            PartState.PROBLEM if soon else PartState.OK, "certificate", detail, remedy
        )
