"""What systemd hears of a service, on a real notification socket."""

from __future__ import annotations

import os
import secrets
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from talaia.service_manager import ServiceManager, own_service_manager


@pytest.fixture(params=["path", "abstract"])
def heard(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[tuple[str, socket.socket]]:
    name = secrets.token_hex(8)
    address = f"@talaia-{name}" if request.param == "abstract" else str(tmp_path / "notify")
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.bind("\0" + address[1:] if address.startswith("@") else address)
        manager.settimeout(5)
        yield address, manager


def test_states_come_one_a_datagram_on_both_kinds_of_sockets(
    heard: tuple[str, socket.socket],
) -> None:
    address, manager = heard
    environment = {"NOTIFY_SOCKET": address, "WATCHDOG_USEC": "20000000", "WATCHDOG_PID": "7"}
    ours = ServiceManager.from_environment(environment, 7)
    assert ours.watchdog_s == 20
    ours.report_ready()
    ours.feed_watchdog()
    ours.report_stopping()
    said = [manager.recv(100).decode() for _ in range(3)]
    assert said == ["READY=1", "WATCHDOG=1", "STOPPING=1"]
    ours.close()
    ours.report_ready()


def test_the_watchdog_of_another_process_is_not_fed(heard: tuple[str, socket.socket]) -> None:
    address, manager = heard
    environment = {"NOTIFY_SOCKET": address, "WATCHDOG_USEC": "20000000", "WATCHDOG_PID": "8"}
    other = ServiceManager.from_environment(environment, 7)
    other.feed_watchdog()
    other.report_ready()
    assert manager.recv(100) == b"READY=1"
    other.close()


def test_a_manager_that_does_not_read_holds_nobody_up(heard: tuple[str, socket.socket]) -> None:
    ours = ServiceManager(heard[0], 1.0)
    for _ in range(10_000):
        ours.feed_watchdog()
    ours.close()


def test_without_a_manager_nothing_is_sent() -> None:
    nobody = ServiceManager.from_environment({"WATCHDOG_USEC": "nonsense"}, 1)
    nobody.report_ready()
    nobody.feed_watchdog()
    assert nobody.watchdog_s == 0


def test_processes_that_are_started_do_not_report_for_us(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NOTIFY_SOCKET", "@nobody")
    monkeypatch.setenv("WATCHDOG_USEC", "1000000")
    own_service_manager().close()
    assert "NOTIFY_SOCKET" not in os.environ
    assert "WATCHDOG_USEC" not in os.environ
