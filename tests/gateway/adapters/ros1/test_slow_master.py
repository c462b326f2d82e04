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
from gateway_bench import addresses_of, drive, running, take_lease
from patience import blocks_for
from ports import free_port
from tapped_hub import newest_list

from talaia.wire.frames import Event, TapSubscription

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

    def __init__(self, uri: str, topics: tuple[str, ...]) -> None:  # noqa: D107
        self._uri = uri
        self._slow = {f"/{name}" for name in topics}
        self.asked: list[str] = []
        self.registered: list[str] = []

    def _dispatch(self, method: str, params: tuple) -> object:
        if method == "registerSubscriber" and params[1] in self._slow:
            self.asked.append(params[1])
            blocks_for(SLOW_S)
            self.registered.append(params[1])
        with xmlrpc.client.ServerProxy(self._uri) as real:
            return getattr(real, method)(*params)


@contextmanager
def slow_master(real: int, topics: tuple[str, ...]) -> Iterator[tuple[int, SlowMaster]]:
    """A slow master before the real one at this port; gives its own port.

    It is slow for those who subscribe one of ``topics``.
    """
    port = free_port()
    slow = SlowMaster(f"http://127.0.0.1:{real}", topics)
    with _Server(("127.0.0.1", port), _Paths, logRequests=False, allow_none=True) as server:
        server.register_instance(slow)
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()
        try:
            yield port, slow
        finally:
            server.shutdown()
            thread.join()


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    ros1_bench.need_ros1()
    home = tmp_path / "ros"
    home.mkdir()
    monkeypatch.setenv("ROS_HOME", str(home))
    monkeypatch.setenv("ROS_IP", "127.0.0.1")
    return home


async def test_a_node_that_waits_for_a_slow_master_is_not_taken_for_one_that_hangs(
    home: Path, tmp_path: Path
) -> None:
    real = free_port()
    signals = "".join(
        f"      {name}: {{name: {name}, source: {{topic: /{name}, "
        "type: std_msgs/msg/Float64, field: data}}\n"
        for name in TOPICS
    )
    with ros1_bench.master(real, home), slow_master(real, TOPICS) as (port, slow):
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


async def test_a_velocity_does_not_wait_for_taps_that_wait_for_a_slow_master(
    home: Path, tmp_path: Path
) -> None:
    tapped = ("odom", "metric", "mode", "scan", "odd")
    real = free_port()
    with ros1_bench.master(real, home), slow_master(real, tapped) as (port, slow):
        site = (
            "talaia: 1\nsite: old\nname: Old\n"
            f'connections: {{old: {{kind: ros1, master: "http://127.0.0.1:{port}"}}}}\n'
            "devices:\n  base:\n    name: Base\n"
            "    drive: {topic: /cmd_vel, max_speed: 0.2, max_turn: 2}\n"
        )
        async with ros1_bench.robot(real, home) as peer, fake_hub(addresses_of) as hub:
            hub.takes = ["topic_list"]
            async with running(hub.url, tmp_path / "data", site):
                await hub.until(lambda: "/odom" in newest_list(hub), "the list of topics")
                epoch = await take_lease(hub)
                await hub.send(TapSubscription(topics={f"/{name}": 0.0 for name in tapped}))
                await hub.until(lambda: slow.asked, "the first of many questions to the master")
                await drive(hub, epoch)
                await peer.until(lambda: any(row[0] > 0 for row in peer.heard("cmd")))
                assert len(slow.registered) < len(tapped)
                await peer.until(lambda: peer.heard("cmd")[-1] == [0.0, 0.0])
