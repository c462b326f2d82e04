"""Another description in the place of the one that the gateway was started with."""

from __future__ import annotations

import asyncio

from talaia.clock import SystemClock
from talaia.gateway.adapters.connection_scope import connection_names, scopes_of
from talaia.gateway.adapters.connectivity import DeviceReachability
from talaia.gateway.adapters.multi_adapter import ConnectionStatus, MultiAdapter
from talaia.gateway.adapters.null_adapter import NullAdapter
from talaia.gateway.reload.connection_exchange import ConnectionExchange
from talaia.gateway.samples.channel_numbering import ChannelNumbering
from talaia.model.yaml_text.load import load_site

BEFORE = """
talaia: 1
site: two
name: Two robots
connections:
  left: {kind: ros2, domain: 1}
  right: {kind: ros2, domain: 2, node: talaia_right}
devices:
  arm: {name: Arm, connection: left}
  base: {name: Base, connection: right}
"""


class _Stopped(NullAdapter):
    """Remembers which devices it was told to stop."""

    def __init__(self) -> None:
        self.devices: list[str] = []

    def stop(self, device: str, *, stopped: bool) -> None:
        self.devices.append(device)


class _Events:
    def report_event(self, kind: str, message: str = "", **about: object) -> None:
        """Nobody listens."""


async def test_a_device_that_moves_to_another_connection_is_told_and_lost_by_that_one() -> None:
    before = load_site(BEFORE)
    after = load_site(BEFORE.replace("connection: left", "connection: right"))
    numbering, made, said = ChannelNumbering(before), {}, []
    of = connection_names(before)
    reachability = DeviceReachability(of, SystemClock(), said.append)

    def make(scope):
        made[scope.name] = _Stopped()
        return made[scope.name], ConnectionStatus(
            scope.name, asyncio.get_running_loop(), reachability
        )

    adapters = {scope.name: make(scope) for scope in scopes_of(before, numbering)}
    adapter = MultiAdapter(of=of, adapters=dict(adapters), reach=reachability, events=_Events())
    exchange = ConnectionExchange(
        site=before,
        numbering=numbering,
        reachability=reachability,
        adapter=adapter,
        adapters=adapters,
        make=make,
    )
    adapter.stop("arm", stopped=True)
    assert made["left"].devices == ["arm"]
    exchange.redescribe(after)
    adapter.stop("arm", stopped=True)
    assert made["right"].devices == ["arm"]
    assert reachability.mark_lost("left", "gone") == []
    assert set(reachability.mark_lost("right", "gone")) == {"arm", "base"}
