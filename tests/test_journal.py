"""What systemd's journal hears: its native protocol, judged by its words and by journald itself."""

from __future__ import annotations

import array
import contextlib
import json
import logging
import os
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given, strategies as st
from patience import PATIENCE_S

from talaia.journal import JournalHandler, encode_entry, is_journal_stream

ROOT = Path(__file__).parents[1]
JOURNALD = Path("/usr/lib/systemd/systemd-journald")


@pytest.fixture
def journal(tmp_path: Path) -> Iterator[socket.socket]:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.bind(str(tmp_path / "socket"))
        listening.settimeout(PATIENCE_S)
        yield listening


@pytest.fixture
def logger(journal: socket.socket) -> Iterator[logging.Logger]:
    made = logging.Logger("talaia.test")
    fields = {"SYSLOG_IDENTIFIER": "talaia-gateway", "TALAIA_SITE": "agv"}
    handler = JournalHandler(
        fields, lambda text: text.replace("secret", "***"), journal.getsockname()
    )
    made.addHandler(handler)
    yield made
    handler.close()


def read_entry(data: bytes) -> dict[str, str]:
    """Read an entry as JOURNAL_NATIVE_PROTOCOL says it is written."""
    fields = {}
    while data:
        line, _, rest = data.partition(b"\n")
        name, equals, value = line.partition(b"=")
        if not equals:
            length = int.from_bytes(rest[:8], "little")
            value, data = rest[8 : 8 + length], rest[8 + length :]
            assert data[:1] == b"\n"
            data = data[1:]
        else:
            data = rest
        fields[name.decode()] = value.decode()
    return fields


def test_a_record_is_an_entry_with_its_fields(
    journal: socket.socket, logger: logging.Logger
) -> None:
    logger.warning("the hub is away: %s", "secret")
    entry = read_entry(journal.recv(65_536))
    assert entry.pop("CODE_LINE").isdecimal()
    assert entry == {
        "MESSAGE": "the hub is away: ***",
        "PRIORITY": "4",
        "SYSLOG_IDENTIFIER": "talaia-gateway",
        "TALAIA_SITE": "agv",
        "LOGGER": "talaia.test",
        "THREAD_NAME": "MainThread",
        "CODE_FILE": __file__,
        "CODE_FUNC": "test_a_record_is_an_entry_with_its_fields",
    }


@pytest.mark.parametrize(
    ("level", "priority"),
    [(50, "2"), (40, "3"), (30, "4"), (20, "6"), (10, "7"), (25, "6"), (5, "7")],
)
def test_levels_are_priorities_of_syslog(
    journal: socket.socket, logger: logging.Logger, level: int, priority: str
) -> None:
    logger.log(level, "x")
    assert read_entry(journal.recv(65_536))["PRIORITY"] == priority


def test_a_traceback_is_a_field_of_its_own_without_secrets(
    journal: socket.socket, logger: logging.Logger
) -> None:
    error = ValueError("secret\nPRIORITY=0")
    logger.error("failed", exc_info=(ValueError, error, None))
    entry = read_entry(journal.recv(65_536))
    assert entry["MESSAGE"] == "failed"
    assert entry["PRIORITY"] == "3"
    assert entry["TRACEBACK"].endswith("ValueError: ***\nPRIORITY=0")


def test_what_fits_no_datagram_is_handed_over_in_a_sealed_file(
    journal: socket.socket, logger: logging.Logger
) -> None:
    logger.error("long %s", "x" * 5_000_000)
    _, ancillary, _, _ = journal.recvmsg(65_536, socket.CMSG_SPACE(4))
    ((_, _, rights),) = ancillary
    (number,) = array.array("i", rights)
    # As the journal finds it: at no certain place.
    with os.fdopen(number, "rb") as file:
        file.seek(0)
        entry = read_entry(file.read())
        with pytest.raises(OSError, match="Operation not permitted"):
            os.ftruncate(number, 0)
    assert entry["MESSAGE"] == "long " + "x" * 5_000_000


def test_a_journal_that_does_not_read_or_is_gone_holds_nobody_up_and_the_line_goes_to_stderr(
    capsys: pytest.CaptureFixture[str], journal: socket.socket, logger: logging.Logger
) -> None:
    for number in range(2_000):
        logger.info("line %d of a secret", number)
    journal.close()
    logger.info("the last")
    said = capsys.readouterr().err
    assert "line 1999 of a ***" in said
    assert "INFO talaia.test: the last" in said


@given(st.dictionaries(st.text(max_size=5) | st.sampled_from(["A", "B_2"]), st.text()))
def test_no_value_makes_a_field_of_its_own(fields: dict[str, str]) -> None:
    entry = read_entry(encode_entry(fields))
    assert set(entry) <= set(fields)
    for name, value in entry.items():
        assert value == fields[name].encode("utf-8", "replace").decode()


def test_a_stream_is_the_journals_only_where_it_is_the_same_file(tmp_path: Path) -> None:
    with (tmp_path / "x").open("w") as file:
        status = os.fstat(file.fileno())
        same = f"{status.st_dev}:{status.st_ino}"
        assert is_journal_stream({"JOURNAL_STREAM": same}, file.fileno())
        assert not is_journal_stream({"JOURNAL_STREAM": same + "1"}, file.fileno())
        assert not is_journal_stream({}, file.fileno())


def test_journald_itself_stores_what_a_gateway_says_with_its_fields(tmp_path: Path) -> None:
    """The real one, with a ``/run`` of its own; its stdout socket is what a unit's stderr is."""
    if not JOURNALD.exists() or not shutil.which("journalctl") or os.geteuid() != 0:
        pytest.skip("systemd's journald can be run by root alone, and where it is installed")
    (tmp_path / "site.yaml").write_text(
        "talaia: 1\nsite: quiet\nname: Quiet\ndevices: {hut: {name: Hut}}\n"
    )
    (tmp_path / "key").write_text("key")
    program = tmp_path / "in_namespace.py"
    program.write_text(
        f"""
import os, subprocess, sys, time
from pathlib import Path
subprocess.run(["mount", "-t", "tmpfs", "tmpfs", "/run"], check=True)
for folder in ("/run/systemd/journal", "/run/log/journal"):
    Path(folder).mkdir(parents=True)
journald = subprocess.Popen([{str(JOURNALD)!r}], stderr=subprocess.DEVNULL)
end = time.monotonic() + {PATIENCE_S}
while not Path("/run/systemd/journal/stdout").exists() and time.monotonic() < end:
    os.sched_yield()
gateway = [sys.executable, "-m", "talaia", "gateway", {str(tmp_path / "site.yaml")!r}]
gateway += ["--hub", "ws://127.0.0.1:1", "--allow-plain", "--key-file", {str(tmp_path / "key")!r}]
gateway += ["--data", {str(tmp_path / "data")!r}]
wanted = ["journalctl", "-D", "/run/log/journal", "-o", "json", "--no-pager", "-q"]
wanted += ["TALAIA_SITE=quiet"]
# systemd-cat makes stderr what a unit's is; the variable it leaves to systemd.
given = 'import os; s = os.fstat(2); os.environ["JOURNAL_STREAM"] = f"{{s.st_dev}}:{{s.st_ino}}"; '
given += "import sys; os.execv(sys.argv[1], sys.argv[1:])"
running = subprocess.Popen(["systemd-cat", "-t", "a-line", sys.executable, "-c", given, *gateway])
found = b""
while b"cannot be reached" not in found and time.monotonic() < end:
    found = subprocess.run(wanted, capture_output=True).stdout
running.terminate()
running.wait()
journald.terminate()
journald.wait()
sys.stdout.buffer.write(found)
"""
    )
    done = subprocess.run(
        ["unshare", "--mount", sys.executable, str(program)],
        env={**os.environ, "PYTHONPATH": str(ROOT / "src")},
        capture_output=True,
        check=False,
        timeout=4 * PATIENCE_S,
    )
    if b"unshare" in done.stderr:
        pytest.skip("no namespace of its own can be made here")
    entries = []
    for line in done.stdout.splitlines():
        with contextlib.suppress(ValueError):
            entries.append(json.loads(line))
    entry = next(entry for entry in entries if "cannot be reached" in str(entry["MESSAGE"]))
    assert entry["PRIORITY"] == "4"
    assert entry["SYSLOG_IDENTIFIER"] == "talaia-gateway"
    assert entry["TALAIA_PROGRAM"] == "gateway"
    assert entry["LOGGER"].startswith("talaia.gateway")
    assert entry["_TRANSPORT"] == "journal"
