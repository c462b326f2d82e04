"""Types that a system's ROS 2 has no package of, by the processes of its own Python.

The other Python is that of `test_system_ros`, kept from some of its packages.
"""

from __future__ import annotations

import asyncio
import os
import signal
import sys
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from fake_hub import FakeHub, fake_hub
from gateway.adapters.ros2.bridged_program import (
    HERE,
    OTHER_PYTHON,
    bridge_of,
    bridged,
    bridged_environment,
    children_of,
)
from gateway.conftest import peer_in
from gateway_bench import addresses_of, command
from patience import PATIENCE_S
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from tapped_hub import newest_list, whole

from talaia.model.discovery.probe_report import TopicFound, found_from
from talaia.wire.frames import (
    CommandCancel,
    CommandPhase,
    CommandRequest,
    CommandState,
    TapSchema,
    TapSubscription,
)

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

NESTED = ("/own/nested", "test_msgs/msg/MultiNested")
SITE = """
talaia: 1
site: test
name: Test robot
ros2: {node: gateway_without_packages}
devices:
  base:
    name: Base
    signals:
      words:
        name: Words
        type: text
        source: {topic: /own/words, type: test_msgs/msg/WStrings, field: wstring_value}
      inner:
        name: Inner
        source:
          topic: /own/nested
          type: test_msgs/msg/MultiNested
          field: bounded_sequence_of_bounded_sequences[0].int16_values[1]
      level:
        name: Level
        source:
          topic: /diagnostics
          type: diagnostic_msgs/msg/DiagnosticArray
          field: status[0].level
    commands:
      order:
        name: Order
        kind: topic
        target: /own/orders
        type: test_msgs/msg/MultiNested
        arguments: {word: {type: text, field: "array_of_arrays[1].string_values[2]"}}
      add:
        name: Add
        target: /add
        type: diagnostic_msgs/srv/AddDiagnostics
        arguments: {space: {type: text, field: load_namespace}}
      silent: {name: Silent, target: /silent/add, type: diagnostic_msgs/srv/AddDiagnostics}
      count:
        name: Count
        kind: action
        target: /count
        type: test_msgs/action/Fibonacci
        progress: sequence[0]
        progress_end: 1000
        arguments: {order: {type: integer, field: order}}
"""
# Run by the other Python before all else: it finds none of these packages.
WITHOUT_PACKAGES = """
import sys

class WithoutPackages:
    @staticmethod
    def find_spec(name, *_):
        if name.partition(".")[0] in ("diagnostic_msgs", "test_msgs"):
            raise ModuleNotFoundError(name + " is kept from this test")

sys.meta_path.insert(0, WithoutPackages)
"""

ASKS_FOR_A_DEFINITION = """
import talaia.gateway.adapters.ros2.system_ros.start
from talaia.gateway.adapters.ros2.type_definitions.distribution_stores import (
    DistributionDefinitions,
)

print(next(iter(DistributionDefinitions().find("sensor_msgs/msg/BatteryState"))).source)
"""


@asynccontextmanager
async def tapped_hub() -> AsyncIterator[FakeHub]:
    async with fake_hub(addresses_of) as hub:
        hub.takes = ["topic_list"]
        yield hub


def schemas(hub: FakeHub) -> list[TapSchema]:
    return [said for said in hub.taps if isinstance(said, TapSchema)]


def poorer_python(folder: Path, **more: str) -> str:
    """Make the other Python anew, without packages that a robot has, and with variables."""
    (folder / "sitecustomize.py").write_text(WITHOUT_PACKAGES)
    python = folder / "python"
    words = " ".join(f"{name}={value}" for name, value in more.items())
    words += f' PYTHONPATH="{folder}:$PYTHONPATH"'
    python.write_text(f'#!/bin/sh\n{words} exec "{OTHER_PYTHON}" "$@"\n')
    python.chmod(0o755)
    return str(python)


async def probed_topics(python: str, seconds: int) -> dict[str, TopicFound]:
    """Listen for a while, as ``talaia probe`` does, and give what it found."""
    probe = await asyncio.create_subprocess_exec(
        sys.executable, "-m", "talaia", "probe", "--ros2", "--seconds", str(seconds), "--json",
        stdout=asyncio.subprocess.PIPE, env=bridged_environment(python),
    )  # fmt: skip
    said, _ = await asyncio.wait_for(probe.communicate(), seconds + PATIENCE_S)
    return {topic.topic: topic for topic in found_from(said, "the probe").topics}


@pytest.mark.robot
@pytest.mark.timeout(90)
async def test_types_that_the_systems_ros_has_no_package_of_are_read_through_it(
    ros_domain: int, tmp_path: Path
) -> None:
    python, site = poorer_python(tmp_path), tmp_path / "site.yaml"
    site.write_text(SITE)
    async with (
        peer_in(ros_domain, HERE / "types_peer.py") as peer,
        tapped_hub() as hub,
        bridged(hub.url, tmp_path / "data", str(site), python=python) as gateway,
    ):
        await peer.do("words", text="añ✓😀")
        await peer.do("nested", text="q")
        await hub.until(lambda: hub.values("base/words") and hub.values("base/inner"), "own types")
        assert (hub.values("base/words"), hub.values("base/inner")) == (["añ✓😀"], [-4.0])
        async with asyncio.timeout(PATIENCE_S):
            while not hub.values("base/level"):
                await peer.do("diagnostics", levels={"motor": 0})
                await asyncio.sleep(0.05)
        for level in (1, 2, 3) * 10:
            await peer.do("diagnostics", levels={"motor": level})
        await hub.until(lambda: hub.values("base/level")[-30:] == [1.0, 2.0, 3.0] * 10, "in order")
        # Looked on at, too: as bytes, with a schema that they are read by.
        await hub.until(lambda: NESTED[0] in newest_list(hub), "the topic in the list")
        await hub.send(TapSubscription(types=[NESTED[1]], topics={NESTED[0]: 0}))
        await hub.until(lambda: whole(hub, NESTED[0]), "its message")
        await hub.until(lambda: schemas(hub), "its schema")
        store = get_typestore(Stores.EMPTY)
        store.register(get_types_from_msg(schemas(hub)[0].definition, NESTED[1]))
        read = store.deserialize_cdr(whole(hub, NESTED[0])[0], NESTED[1])
        texts = read.bounded_sequence_of_bounded_sequences[0].string_values
        assert texts == ["x", "q"]
        # A new bridge knows them, too; the latched one comes again.
        os.kill(bridge_of(gateway.pid), signal.SIGKILL)
        await hub.until(lambda: hub.values("base/inner") == [-4.0, -4.0], "the latched one again")
        # A busy machine needs longer than is usual.
        for seconds in (3, 15):
            topics = await probed_topics(python, seconds)
            paths = {field.path for field in topics["/own/words"].fields}
            if paths:
                break
        assert (topics["/own/words"].problem, "wstring_value" in paths) == ("", True)


@pytest.mark.robot
@pytest.mark.timeout(90)
async def test_what_the_systems_ros_has_no_package_of_is_published_called_and_done(
    ros_domain: int, tmp_path: Path
) -> None:
    python, site = poorer_python(tmp_path), tmp_path / "site.yaml"
    site.write_text(SITE)
    async with (
        peer_in(ros_domain, HERE / "types_peer.py") as peer,
        fake_hub(addresses_of) as hub,
        bridged(hub.url, tmp_path / "data", str(site), python=python) as gateway,
    ):
        await peer.do("words", text="here")
        await hub.until(lambda: hub.values("base/words"), "own types")
        for number, word in enumerate(("begin", "añ✓😀")):
            done = await command(hub, "order", f"order{number}", word=word)
            assert (done.phase, done.message) == (CommandPhase.SUCCEEDED, "published")
            await peer.until(lambda number=number: len(peer.heard("order")) > number)
        assert peer.heard("order") == [["begin", 0, False], ["añ✓😀", 0, False]]
        for number, (space, phase) in enumerate(
            (("/ns", CommandPhase.SUCCEEDED), ("none", CommandPhase.FAILED))
        ):
            done = await command(hub, "add", f"add{number}", space=space)
            assert (done.phase, done.message) == (phase, f"asked for {space}")
        # Another process of that Python calls: what hangs there holds up no driving.
        callers = [each for each in children_of(gateway.pid) if calls_services(each)]
        assert len(callers) == 1
        done = await command(hub, "silent", "silent")
        assert done.phase is CommandPhase.REFUSED
        assert "does not say which version" in done.message
        assert peer.heard("added") == ["/ns", "none"]
        done = await command(hub, "count", "count1", order=3)
        assert done.phase is CommandPhase.SUCCEEDED, done
        asked = {"device": "base", "command": "count", "ttl_ms": 5000, "who": "Ada"}
        await hub.send(CommandRequest(id="long", args={"order": 1000}, **asked))
        await hub.next(CommandState, lambda state: state.id == "long" and state.progress > 0.004)
        await hub.send(CommandCancel(id="long", device="base", who="Ada"))
        await hub.next(
            CommandState,
            lambda state: state.id == "long" and state.phase is CommandPhase.CANCELLED,
        )
        assert peer.heard("goal") == [3, 1000]


def calls_services(pid: int) -> bool:
    return b"service-caller" in Path(f"/proc/{pid}/cmdline").read_bytes()


@pytest.mark.robot
async def test_without_hashes_definitions_are_those_of_the_systems_distribution(
    ros_domain: int, tmp_path: Path
) -> None:
    """As after a ``setup.bash`` that only the bridge has read."""
    python = poorer_python(tmp_path, ROS_DISTRO="humble")
    gateway = await asyncio.create_subprocess_exec(
        sys.executable, "-c", ASKS_FOR_A_DEFINITION,
        stdout=asyncio.subprocess.PIPE, env=bridged_environment(python),
    )  # fmt: skip
    said, _ = await asyncio.wait_for(gateway.communicate(), PATIENCE_S)
    assert said.decode().strip() == "the definitions of ROS 2 Humble"
