"""The SNMP example, against a real agent: snmpsim with the outlets of a power switch."""

from __future__ import annotations

import asyncio
import importlib.util
import os
import signal
import socket
import sys
from typing import TYPE_CHECKING

import pytest

from talaia.wire.frames import CommandPhase

from .adapter_bench import adapting

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

OUTLET = "1.3.6.1.4.1.318.1.1.12.3.3.1.1.4"
SITE = """
talaia: 1
site: dome
name: Dome
connections:
  pdu:
    kind: extension
    extension: snmp
    keys: {{host: 127.0.0.1, port: {port}, poll: 0.1, timeout: 5, write_file: community}}
devices:
  power:
    name: Power
    kind: power
    signals:
      lamp: {{name: Lamp, type: state, states: ["off", "on"], source: {{keys: {{outlet: 1}}}}}}
      mount: {{name: Mount, type: state, states: ["off", "on"], source: {{keys: {{outlet: 2}}}}}}
      model: {{name: Model, type: text, source: {{keys: {{oid: 1.3.6.1.2.1.1.1.0}}}}}}
    commands:
      lamp_off:
        name: Lamp off
        kind: extension
        target: outlet
        fixed: {{outlet: 1, state: "off"}}
      switch:
        name: Switch
        kind: extension
        target: outlet
        arguments:
          outlet: {{type: integer, field: outlet}}
          state: {{type: text, field: state}}
"""


@pytest.fixture
async def port(tmp_path: Path, beside: Path) -> AsyncIterator[int]:
    """Run an agent whose outlets keep what is written to them."""
    if importlib.util.find_spec("snmpsim") is None and not os.environ.get("TALAIA_REQUIRE_ALL"):
        pytest.skip("snmpsim is not installed")
    data = tmp_path / "agent"
    data.mkdir()
    rows = ["1.3.6.1.2.1.1.1.0|4|APC Rack PDU AP7920"]
    rows += [f"{OUTLET}.{number}|2:writecache|value={state}" for number, state in ((1, 1), (2, 2))]
    for community in ("public", "secret"):
        (data / f"{community}.snmprec").write_text("\n".join(rows) + "\n")
    (tmp_path / "community").write_text("public\n")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        number = probe.getsockname()[1]
    agent = await asyncio.create_subprocess_exec(
        sys.executable, "-W", "ignore", "-c",
        "import sys; from snmpsim.commands.responder import main; sys.exit(main())",
        "--quiet", "--log-level=error", f"--data-dir={data}", f"--cache-dir={tmp_path / 'cache'}",
        f"--variation-module-options=writecache:file:{tmp_path / 'written.db'}",
        "--process-user=root", "--process-group=root",
        f"--agent-udpv4-endpoint=127.0.0.1:{number}",
    )  # fmt: skip
    yield number
    agent.send_signal(signal.SIGTERM)
    await agent.wait()


async def test_a_power_switch_is_read_and_switched_over_snmp(port: int, tmp_path: Path) -> None:
    async with adapting(SITE.format(port=port), tmp_path) as bench:
        await bench.until(lambda: len(bench.values) == 3)
        assert bench.values == {
            "power/lamp": 1.0, "power/mount": 0.0, "power/model": "APC Rack PDU AP7920",
        }  # fmt: skip
        done = await bench.do("power", "lamp_off")
        assert (done.phase, done.message) == (CommandPhase.SUCCEEDED, "outlet 1 is off")
        await bench.until(lambda: bench.values["power/lamp"] == 0.0)
        done = await bench.do("power", "switch", outlet=2, state="on")
        assert done.phase is CommandPhase.SUCCEEDED
        await bench.until(lambda: bench.values["power/mount"] == 1.0)
        # What a person writes is one of three words, or nothing is switched.
        done = await bench.do("power", "switch", outlet=2, state="maybe")
        assert done.phase is CommandPhase.REFUSED
        assert "state" in done.message


async def test_an_outlet_that_is_not_there_fails_in_the_agents_words(
    port: int, tmp_path: Path
) -> None:
    async with adapting(SITE.format(port=port), tmp_path) as bench:
        await bench.until(lambda: len(bench.values) == 3)
        done = await bench.do("power", "switch", outlet=77, state="on")
        assert done.phase is CommandPhase.FAILED
        assert done.message
