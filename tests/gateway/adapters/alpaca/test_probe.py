"""What a probe finds at Alpaca servers, and the description that is made of it."""

from __future__ import annotations

import socket
import threading
from typing import TYPE_CHECKING

import pytest
from stand_in import serving_alpaca

from talaia.gateway.adapters.alpaca.probe import probe_alpaca
from talaia.gateway.adapters.alpaca.search import search_servers
from talaia.gateway.errors import AdapterLost
from talaia.model.checks.site_checks import check_site
from talaia.model.discovery.generate_description import propose_description
from talaia.model.roles import CommandRole, SignalRole
from talaia.model.yaml_text.load import load_site
from talaia.model.yaml_text.write import write_description

if TYPE_CHECKING:
    from collections.abc import Iterator


def test_the_simulators_become_a_description_that_runs(simulators: int) -> None:
    found = probe_alpaca("127.0.0.1", simulators, connect=True)
    made = propose_description(found, "roof", "Roof", "UTC")
    assert made.left_out == ()
    assert not check_site(made.site)
    # It was probed on this computer, and says so.
    again = load_site(write_description(made.site, []))
    assert again.connections["alpaca"].here is True
    dome = again.devices["dome_0"]
    assert dome.signals["shutterstatus"].role is SignalRole.DOME_SHUTTER
    assert dome.commands["close"].role is CommandRole.DOME_CLOSE
    assert again.devices["camera_0"].commands["expose"].arguments["binning"].maximum == 8


def test_a_probe_connects_nothing_unless_it_is_told_to() -> None:
    with serving_alpaca() as (port, stand_in):
        stand_in.values |= {"dome/0/connected": False, "dome/0/shutterstatus": 1}
        stand_in.on_put["dome/0/connected"] = lambda _: stand_in.values.update(
            {"dome/0/connected": True}
        )
        (dome,) = probe_alpaca("127.0.0.1", port).devices
        assert (dome.connected, dome.described, stand_in.puts) == (False, None, [])
        (dome,) = probe_alpaca("127.0.0.1", port, connect=True).devices
        assert dome.connected
        assert dome.described is not None
        assert stand_in.calls("dome/0/connected") == 1


def test_what_is_no_alpaca_server_is_told(simulators: int) -> None:
    with socket.create_server(("127.0.0.1", 0)) as nobody:
        port = nobody.getsockname()[1]
    with pytest.raises(AdapterLost, match="none answers"):
        probe_alpaca("127.0.0.1", port)


@pytest.fixture
def answering() -> Iterator[tuple[int, list[bytes]]]:
    """A port at which discovery is answered with what a test has put there."""
    answers: list[bytes] = []
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.bind(("", 0))

        def answer() -> None:
            data, asker = line.recvfrom(100)
            assert data == b"alpacadiscovery1"
            for said in answers:
                line.sendto(said, asker)

        thread = threading.Thread(target=answer)
        thread.start()
        yield line.getsockname()[1], answers
        thread.join()


def test_servers_that_answer_a_broadcast_are_found_and_nonsense_is_not(
    answering: tuple[int, list[bytes]],
) -> None:
    port, answers = answering
    answers += [b"\xff", b'{"AlpacaPort": 99999}', b'{"AlpacaPort": 11111}', b"{}"]
    found = search_servers(0.5, at=port)
    assert {server.port for server in found} == {11111}
