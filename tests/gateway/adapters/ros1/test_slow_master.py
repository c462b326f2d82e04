"""A ROS 1 master that is slow, as on a machine with other work, keeps no robot away."""

from __future__ import annotations

import socketserver
import threading
import xmlrpc.client
from contextlib import contextmanager
from typing import TYPE_CHECKING
from xmlrpc.server import SimpleXMLRPCRequestHandler, SimpleXMLRPCServer

import pytest
from fake_hub import fake_hub
from gateway_bench import addresses_of, running
from patience import blocks_for
from ports import free_port

from talaia.wire.frames import Event

from . import ros1_bench

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

pytestmark = pytest.mark.robot
# Each registration; all together take much longer than the silence by which a node hangs.
SLOW_S = 0.8
TOPICS = ("number", "a", "b", "c", "d", "e")


class _Paths(SimpleXMLRPCRequestHandler):
    rpc_paths = ()


class _Server(socketserver.ThreadingMixIn, SimpleXMLRPCServer):
    daemon_threads = True


class SlowMaster:
    """Stands before a real master, and lets whoever subscribes wait."""

    def __init__(self, uri: str) -> None:  # noqa: D107
        self._uri = uri
        self.registered: list[str] = []

    def _dispatch(self, method: str, params: tuple) -> object:
        if method == "registerSubscriber" and params[1] in {f"/{name}" for name in TOPICS}:
            blocks_for(SLOW_S)
            self.registered.append(params[1])
        with xmlrpc.client.ServerProxy(self._uri) as real:
            return getattr(real, method)(*params)


@contextmanager
def slow_master(real: int) -> Iterator[tuple[int, SlowMaster]]:
    """A slow master before the real one at this port; gives its own port."""
    port = free_port()
    slow = SlowMaster(f"http://127.0.0.1:{real}")
    with _Server(("127.0.0.1", port), _Paths, logRequests=False, allow_none=True) as server:
        server.register_instance(slow)
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()
        try:
            yield port, slow
        finally:
            server.shutdown()
            thread.join()


async def test_a_node_that_waits_for_a_slow_master_is_not_taken_for_one_that_hangs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ros1_bench.need_ros1()
    home = tmp_path / "ros"
    home.mkdir()
    monkeypatch.setenv("ROS_HOME", str(home))
    monkeypatch.setenv("ROS_IP", "127.0.0.1")
    real = free_port()
    signals = "".join(
        f"      {name}: {{name: {name}, source: {{topic: /{name}, "
        "type: std_msgs/msg/Float64, field: data}}\n"
        for name in TOPICS
    )
    with ros1_bench.master(real, home), slow_master(real) as (port, slow):
        site = (
            "talaia: 1\nsite: old\nname: Old\n"
            f'connections: {{old: {{kind: ros1, master: "http://127.0.0.1:{port}"}}}}\n'
            f"devices:\n  base:\n    name: Base\n    signals:\n{signals}"
        )
        async with (
            ros1_bench.robot(real, home) as peer,
            fake_hub(addresses_of) as hub,
            running(hub.url, tmp_path / "data", site),
        ):
            await hub.until(lambda: len(slow.registered) >= len(TOPICS), "all topics")
            await peer.until_heard_by(1)
            await peer.do("count", **{"from": 7, "to": 8, "hz": 100})
            await hub.until(lambda: 7.0 in hub.values("base/number"), "a value")
            assert sorted(slow.registered) == sorted(f"/{name}" for name in TOPICS)
            lost = [each for each in hub.messages if isinstance(each, Event)]
            assert [each.message for each in lost if each.kind == "connection lost"] == []
