"""Whether a machine is fit for a hub: what runs, its port, disk and certificate."""

from __future__ import annotations

import datetime as dt
import socket
from pathlib import Path

from talaia.cli.examining.findings import PartFinding, PartState
from talaia.cli.examining.host import examine_host, running_programs
from talaia.hub.certificate import own_certificate
from talaia.hub.settings import Settings


def found(data: Path, port: int = 0) -> dict[str, PartFinding]:
    return {each.what: each for each in examine_host(data, port)}


def test_programs_are_told_by_their_words_and_others_are_left_alone(tmp_path: Path) -> None:
    for number, words in (
        (7, ["/venv/bin/python", "/venv/bin/talaia", "hub", "--port", "8443", ""]),
        (8, ["python3", "-m", "talaia", "gateway", "site.yaml", ""]),
        (9, ["talaia", "doctor", ""]),
        (10, ["vim", "notes/hub", ""]),
        (11, ["python3", "talaia", ""]),
    ):
        folder = tmp_path / str(number)
        folder.mkdir()
        (folder / "cmdline").write_bytes("\0".join(words).encode())
    (tmp_path / "12").mkdir()
    told = sorted((program.pid, program.words) for program in running_programs(tmp_path))
    assert told == [(7, ("hub", "--port", "8443")), (8, ("gateway", "site.yaml"))]


def test_a_port_that_another_program_has_is_a_problem_with_a_way_out(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        one = found(tmp_path, port)[f"port {port}"]
    # Beside a running hub, of this machine's other users say, it may be that one's.
    assert "taken" in one.detail
    assert found(tmp_path)["port 0"] == PartFinding(PartState.OK, "port 0", "free")


def test_the_disk_is_that_of_the_folder_that_will_be_made(tmp_path: Path) -> None:
    disk = found(tmp_path / "not" / "there")["disk"]
    assert disk.detail.endswith(f"GB are free at {tmp_path}")


def test_a_certificate_is_told_by_the_days_it_is_good_for(tmp_path: Path) -> None:
    assert found(tmp_path)["certificate"].state is PartState.ABSENT
    now = dt.datetime.now(dt.UTC)
    cert = own_certificate(Settings(data=tmp_path), now).cert
    good = found(tmp_path)["certificate"]
    assert good.state is PartState.OK
    assert "good for" in good.detail
    cert.write_text("no certificate")
    bad = found(tmp_path)["certificate"]
    assert bad.state is PartState.PROBLEM
    assert bad.remedy


def test_the_clock_says_the_time_and_whether_something_sets_it(tmp_path: Path) -> None:
    clock = found(tmp_path)["clock"]
    assert "UTC" in clock.detail
    assert (clock.state is PartState.OK) == ("synchronized" in clock.detail)
