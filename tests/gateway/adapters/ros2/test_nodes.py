"""Nodes of a real robot between it and a hub: life cycles, parameters, and what a probe makes."""

from __future__ import annotations

import asyncio
import time
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import pytest
import pytest_asyncio
from fake_hub import FakeHub, fake_hub
from gateway.conftest import peer_in
from gateway_bench import Peer, addresses_of, running
from patience import PATIENCE_S

from talaia.model.checks.site_checks import check_site
from talaia.model.connections.ros import LIFECYCLE_STATES, RosSource
from talaia.model.discovery.generate_description import propose_description
from talaia.model.yaml_text.load import load_site
from talaia.model.yaml_text.write import write_description
from talaia.wire.frames import CommandPhase, CommandRequest, CommandState, Event, LogLine

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from talaia.model.discovery.generate_description import DescriptionProposal

pytestmark = [pytest.mark.robot, pytest.mark.asyncio(loop_scope="module")]


class Bench(NamedTuple):
    """A robot, what a probe proposes of it, and the hub of a gateway that goes by just that."""

    peer: Peer
    proposal: DescriptionProposal
    hub: FakeHub


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def bench(own_domain: int, tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Bench]:
    pytest.importorskip("rclpy", reason="needs ROS 2")
    from talaia.gateway.adapters.ros2.probe import probe_graph

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_DOMAIN_ID", str(own_domain))
        patch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        folder = tmp_path_factory.mktemp("gateway")
        async with peer_in(own_domain, Path(__file__).with_name("nodes_peer.py")) as peer:
            found = await asyncio.to_thread(probe_graph, None, 3.0)
            proposal = propose_description(found, "robot", "Robot", "UTC")
            text = write_description(proposal.site)
            async with fake_hub(addresses_of) as hub, running(hub.url, folder, text):
                hub.takes = ["robot_log"]
                await hub.until(lambda: hub.hellos, "a hello")
                await hub.until(lambda: hub.values("front_lidar/life_cycle"), "a state")
                yield Bench(peer, proposal, hub)


COUNT = iter(range(1000))


async def ask(bench: Bench, name: str, **args: object) -> CommandState:
    """Ask the lidar for something, and wait for how it ends."""
    command_id = f"{name}{next(COUNT)}"
    request = CommandRequest(
        id=command_id, device="front_lidar", command=name, args=args, ttl_ms=5000, who="Ada"
    )
    await bench.hub.send(request)
    under_way = {CommandPhase.ACCEPTED, CommandPhase.RUNNING}
    return await bench.hub.next(
        CommandState, lambda state: state.id == command_id and state.phase not in under_way
    )


def states(bench: Bench) -> list[str]:
    return [LIFECYCLE_STATES[int(each)] for each in bench.hub.values("front_lidar/life_cycle")]


async def test_a_description_of_its_nodes_is_proposed(bench: Bench) -> None:
    site = bench.proposal.site
    assert load_site(write_description(site)) == site
    assert check_site(site) == []
    assert list(site.devices) == ["front_lidar", "tank"]
    lidar = site.devices["front_lidar"]
    assert lidar.signals["life_cycle"].source == RosSource(lifecycle="/front/lidar")
    assert [name for name, signal in lidar.signals.items() if signal.primary] == ["life_cycle"]
    # No number of /rosout, /parameter_events or the node's own services.
    lists = {
        "angles": "numbers", "beams": "integers", "frames": "texts", "mirrors": "booleans",
        "serial": "bytes",
    }  # fmt: skip
    assert sorted(lidar.signals) == sorted(["life_cycle", "echoes", "model", "motor_rate", *lists])
    assert sorted(lidar.commands) == sorted([
        "configure", "activate", "deactivate", "cleanup", "shutdown", "set_echoes",
        "set_motor_rate", *(f"set_{name}" for name in lists),
    ])  # fmt: skip
    for name, kind in lists.items():
        assert lidar.commands[f"set_{name}"].arguments["value"].type == kind
        assert lidar.signals[name].type == "text"
    rate = lidar.commands["set_motor_rate"]
    assert rate.description == "Turns a second"
    assert (rate.arguments["value"].minimum, rate.arguments["value"].maximum) == (1, 20)
    left_out = " ".join(bench.proposal.left_out)
    assert "wifi_password: by its name it is a secret" in left_out
    assert "mask: a list that takes 890 characters" in left_out
    assert "key_code: by its name it is a secret" in left_out
    assert "hunter2" not in str(site)


async def test_a_life_cycle_is_led_through_its_states(bench: Bench) -> None:
    assert states(bench)[-1] == "unconfigured"
    for command, state in (("configure", "inactive"), ("activate", "active")):
        ended = await ask(bench, command)
        assert (ended.phase, ended.message) == (
            CommandPhase.SUCCEEDED,
            f"/front/lidar is {state} now",
        )
        await bench.hub.until(lambda state=state: states(bench)[-1] == state, state)
    assert bench.peer.heard("activating") == [True]


async def test_a_transition_that_leads_nowhere_from_here_is_refused_with_those_that_do(
    bench: Bench,
) -> None:
    await ask(bench, "configure")
    await ask(bench, "activate")
    await bench.hub.until(lambda: states(bench)[-1] == "active", "active")
    ended = await ask(bench, "cleanup")
    assert ended.phase is CommandPhase.REFUSED
    assert ended.message == (
        "/front/lidar is active: it cannot cleanup now, but deactivate, shutdown"
    )
    assert states(bench)[-1] == "active"


async def test_a_transition_that_the_node_fails_is_told_with_the_state_it_is_in(
    bench: Bench,
) -> None:
    await ask(bench, "configure")
    await ask(bench, "deactivate")
    await bench.hub.until(lambda: states(bench)[-1] == "inactive", "inactive")
    await bench.peer.do("fail", fails=True)
    # Its order and the gateway's come by different ways.
    await bench.peer.until(lambda: "fail" in bench.peer.heard("did"))
    ended = await ask(bench, "activate")
    await bench.peer.do("fail", fails=False)
    assert ended.phase is CommandPhase.FAILED
    assert "/front/lidar did not activate: it is inactive now" in ended.message


async def test_parameters_are_read_and_set_and_a_refusal_is_in_the_nodes_words(
    bench: Bench,
) -> None:
    hub = bench.hub
    await hub.until(lambda: hub.values("front_lidar/motor_rate"), "a parameter")
    assert hub.values("front_lidar/model")[-1] == "A1"
    assert (await ask(bench, "set_motor_rate", value=12)).phase is CommandPhase.SUCCEEDED
    await hub.until(lambda: hub.values("front_lidar/motor_rate")[-1] == 12, "the new value")
    refused = await ask(bench, "set_motor_rate", value=30)
    assert (refused.phase, refused.message) == (CommandPhase.REFUSED, "value: 30 is above 20.0")
    refused = await ask(bench, "set_echoes", value=4)
    assert (refused.phase, refused.message) == (CommandPhase.FAILED, "at most three echoes")
    assert (await ask(bench, "set_echoes", value=3)).phase is CommandPhase.SUCCEEDED
    assert bench.peer.heard("set")[-2:] == [{"motor.rate": 12.0}, {"echoes": 3}]


@pytest.mark.parametrize(
    ("name", "before", "typed", "taken", "shown"),
    [
        ("angles", "[1.0, 2.0]", "0.5, 3", [0.5, 3.0], "[0.5, 3.0]"),
        ("beams", "[1, -2]", "[4, 5, 6]", [4, 5, 6], "[4, 5, 6]"),
        ("mirrors", "[true, false]", "on, off, true", [True, False, True], "[true, false, true]"),
        ("frames", '["a, b", "c"]', "", [], "[]"),
        ("serial", "[1, 255]", "0, 7", [0, 7], "[0, 7]"),
    ],
)
async def test_a_list_is_read_as_one_text_and_set_by_one(
    bench: Bench, name: str, before: str, typed: str, taken: list[object], shown: str
) -> None:
    hub, address = bench.hub, f"front_lidar/{name}"
    await hub.until(lambda: hub.values(address), "the list")
    assert hub.values(address)[0] == before
    assert (await ask(bench, f"set_{name}", value=typed)).phase is CommandPhase.SUCCEEDED
    assert bench.peer.heard("set")[-1] == {name: taken}
    await hub.until(lambda: hub.values(address)[-1] == shown, "the new list")


async def test_what_is_no_list_of_its_type_is_refused_with_the_item(bench: Bench) -> None:
    heard = len(bench.peer.heard("set"))
    refused = await ask(bench, "set_beams", value="1, 2.5")
    assert (refused.phase, refused.message) == (
        CommandPhase.REFUSED,
        "value: item 2: expected a whole number, found 2.5",
    )
    assert len(bench.peer.heard("set")) == heard


async def test_the_robots_log_stands_in_the_logbook_and_a_flood_costs_little(bench: Bench) -> None:
    peer, hub = bench.peer, bench.hub
    await peer.do("log", level="info", text="nobody reads this {}", count=1)
    await peer.do("log", level="error", text="the pump is dry", count=1)
    event = await hub.next(Event, lambda one: one.kind == "robot_log" and "pump" in one.message)
    assert (event.message, event.good) == ("[ERROR] talker: the pump is dry", False)
    await peer.do("log", level="warning", text="line {}", count=3000)
    # There is room for others beside it.
    await peer.do("log", node="lidar", level="error", text="no echo", count=1)

    def lines() -> list[str]:
        return [
            one.message
            for one in hub.messages
            if isinstance(one, Event) and one.kind == "robot_log"
        ]

    await hub.until(lambda: "[ERROR] front.lidar: no echo" in lines(), "the lidar's line")
    # Five of a node at once, of which one was the pump's.
    assert [line for line in lines() if "talker" in line] == [
        f"[WARNING] talker: line {number}" for number in range(4)
    ]


async def test_the_robots_log_is_kept_over_a_lost_link_and_its_floods_are_counted(
    bench: Bench,
) -> None:
    peer, hub = bench.peer, bench.hub
    hub.takes = ["robot_log"]
    links = len(hub.links)
    hub.cut()
    for number in range(20):
        # More than the logbook takes of one node.
        await peer.do("log", node="lidar", level="warning", text=f"beam {number}", count=1)
    await peer.do("log", node="lidar", level="error", text="\x1b[31mlost\x00\ttrack", count=1)
    await peer.do("log", node="lidar", level="error", text="x" * 100_000, count=1)
    await hub.until(lambda: len(hub.links) > links, "a new link")

    def lidar() -> list[LogLine]:
        return [line for line in hub.log_lines() if line.node == "front.lidar"]

    await hub.until(lambda: any("cut: the line has" in one.text for one in lidar()), "all of them")
    said = [one for one in lidar() if one.text.startswith("beam")]
    assert [one.text for one in said] == [f"beam {number}" for number in range(20)]
    assert {(one.level, one.file.endswith("nodes_peer.py"), one.line > 0) for one in said} == {
        (30, True, True)
    }
    assert abs(said[0].time_us - time.time_ns() // 1000) < 60_000_000
    # A flood takes nothing from others.
    await peer.do("log", level="warning", text="flood {}", count=1000)
    await peer.do("log", node="lidar", level="error", text="still here", count=1)
    await hub.until(lambda: any(one.text == "still here" for one in lidar()), "the lidar's line")
    flood = [one for one in hub.log_lines() if one.text.startswith("flood")]
    # A gateway that is slow hears less of it: what its queue has no room for.
    assert 0 < len(flood) < 600


async def test_stamps_go_by_the_robots_clock(bench: Bench) -> None:
    peer, hub = bench.peer, bench.hub
    assert bench.proposal.site.ros2 is not None
    assert bench.proposal.site.ros2.use_sim_time
    async with asyncio.timeout(PATIENCE_S):
        while 2.0 not in hub.values("tank/heat_temperature"):
            await peer.do("clock", sec=1000)
            await peer.do("heat", value=1.0, sec=1000)
            await peer.do("heat", value=2.0, sec=998)
            await asyncio.sleep(0.05)
    times = {
        value: time_us
        for samples in hub.samples.values()
        for name, time_us, value in samples.values()
        if name == "tank/heat_temperature"
    }
    assert 1.5 < (times[1.0] - times[2.0]) / 1e6 < 2.5
