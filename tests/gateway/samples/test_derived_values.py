"""Signals over signals at the gateway: when they are worked out, of what, and when they are not."""

from __future__ import annotations

import asyncio
from math import nan
from typing import TYPE_CHECKING

import numpy as np
from fake_hub import fake_hub
from gateway_bench import addresses_of, running

from talaia.clock import SECOND, HandClock
from talaia.gateway.samples.channel_numbering import ChannelNumbering
from talaia.gateway.samples.derived_values import PERIOD_S, DerivedValues
from talaia.model.yaml_text.load import load_site
from talaia.wire.columns import Columns

if TYPE_CHECKING:
    from pathlib import Path

    from talaia.model.site import Site

SITE = """
talaia: 1
site: test
name: Test
connections: {shell: {kind: process, poll: 0.1}}
devices:
  w:
    name: Weather
    signals:
      outside:
        {name: O, unit: "°C", minimum: -50, maximum: 60, max_age: 5, source: {run: cat OUTSIDE}}
      dew: {name: D, unit: "°C", max_age: 5, source: {run: cat DEW}}
      roof: {name: R, type: state, states: [shut, open], source: {run: cat ROOF}}
      spread: {name: S, unit: "°C", source: {expression: "{w/outside} - {w/dew}"}}
      twice: {name: T, unit: "°C", source: {expression: "{w/spread} * 2"}}
      damp:
        name: Damp
        type: state
        states: ["no", "yes"]
        source: {expression: '{w/spread} < 3 and {w/roof} == "open"'}
      alarm: {name: A, type: state, states: [off, on_], source: {expression: '{w/damp} == "yes"'}}
      slow: {name: L, unit: "°C", max_rate: 1, source: {expression: "{w/outside} + 0"}}
""".replace("states: [off, on_]", 'states: ["off", "on"]')


class Sink:
    """Keeps what is put, by address."""

    def __init__(self, site: Site) -> None:  # noqa: D107
        self._addresses = [channel.address for channel in site.channels()]
        self.rows: list[tuple[str, int, float]] = []

    def put_samples(self, columns: Columns) -> None:
        for channel, time_us, value in zip(
            columns.channel.tolist(), columns.time_us.tolist(), columns.value.tolist(), strict=True
        ):
            self.rows.append((self._addresses[channel], time_us, value))

    def of(self, address: str) -> list[tuple[int, float]]:
        return [(time_us, value) for name, time_us, value in self.rows if name == address]


class Bench:
    """A site whose signals a test says, with a clock moved by hand."""

    def __init__(self) -> None:  # noqa: D107
        self.site = load_site(SITE)
        self.clock = HandClock()
        self.sink = Sink(self.site)
        self.numbers = ChannelNumbering(self.site).numbers_of(self.site)
        self.values = DerivedValues(
            site=self.site,
            numbers=self.numbers,
            sink=self.sink,
            clock=self.clock,
            loop=asyncio.get_running_loop(),
        )

    async def hear(self, **values: float) -> None:
        """Let signals be heard at one moment, and what follows from them be worked out."""
        time_us = self.clock.wall_ns() // 1000
        self.values.put_samples(
            Columns(
                np.array([self.numbers[f"w/{name}"] for name in values], np.uint16),
                np.full(len(values), time_us, np.int64),
                np.array([*values.values()], np.float64),
                {},
            )
        )
        await self.work()

    async def work(self) -> None:
        # Called by the loop: twice, for the first call only arms the timer.
        self.clock.advance(round(2 * PERIOD_S * SECOND))
        for _ in range(4):
            await asyncio.sleep(0)
        self.values._due_ns = 0
        if self.values._timer is not None:
            self.values._timer.cancel()
            self.values._work_out()

    def last(self, name: str) -> float | None:
        rows = self.sink.of(f"w/{name}")
        return rows[-1][1] if rows else None


async def test_value_follows_its_inputs_in_order_with_the_newest_inputs_time() -> None:
    bench = Bench()
    await bench.hear(outside=12.0)
    assert bench.last("spread") is None
    bench.clock.advance(SECOND)
    time_us = bench.clock.wall_ns() // 1000
    await bench.hear(dew=10.5, roof=1.0)
    assert bench.sink.of("w/spread") == [(time_us, 1.5)]
    assert (bench.last("twice"), bench.last("damp"), bench.last("alarm")) == (3.0, 1.0, 1.0)


async def test_unknown_input_gives_no_value_and_a_known_one_again() -> None:
    bench = Bench()
    await bench.hear(outside=12.0, dew=10.0)
    for unknown in (nan, 999.0):
        count = len(bench.sink.of("w/spread"))
        await bench.hear(outside=unknown)
        assert len(bench.sink.of("w/spread")) == count
        await bench.hear(outside=13.0)
        assert bench.last("spread") == 3.0
    # One side is false whatever the roof says, which nobody has heard of.
    assert bench.last("damp") == 0.0


async def test_stale_input_gives_no_value_though_another_goes_on() -> None:
    bench = Bench()
    await bench.hear(outside=12.0, dew=10.0)
    bench.clock.advance(4 * SECOND)
    await bench.hear(outside=13.0)
    assert bench.last("twice") == 6.0
    bench.clock.advance(2 * SECOND)
    await bench.hear(outside=14.0)
    assert (bench.last("spread"), bench.last("twice")) == (3.0, 6.0)


async def test_device_that_is_lost_or_not_reached_gives_nothing() -> None:
    bench = Bench()
    await bench.hear(outside=12.0, dew=10.0)
    reached = [False]
    bench.values.attach_reachability(lambda _device: reached[0])
    await bench.hear(outside=13.0)
    assert bench.last("spread") == 2.0
    reached[0] = True
    bench.values.forget_devices(["w"])
    await bench.hear(outside=14.0)
    assert bench.last("spread") == 2.0
    await bench.hear(dew=10.0)
    assert bench.last("spread") == 4.0


async def test_burst_is_worked_out_once_and_its_own_rate_keeps_the_last() -> None:
    bench = Bench()
    await bench.hear(outside=1.0, dew=0.0)
    for outside in (2.0, 3.0, 4.0):
        await bench.hear(outside=outside)
    assert bench.last("slow") == 1.0
    bench.clock.advance(SECOND)
    await bench.work()
    assert [value for _, value in bench.sink.of("w/slow")] == [1.0, 4.0]


async def test_changed_expression_counts_from_then_on() -> None:
    bench = Bench()
    await bench.hear(outside=12.0, dew=10.0)
    after = load_site(SITE.replace("{w/outside} - {w/dew}", "{w/dew} - {w/outside}"))
    bench.values.redescribe(after, bench.numbers)
    await bench.hear(outside=13.0)
    assert bench.last("spread") == -3.0


async def test_hub_gets_what_a_running_gateway_works_out(tmp_path: Path) -> None:
    text, files = SITE, {"OUTSIDE": "12.5", "DEW": "10", "ROOF": "open"}
    for word, said in files.items():
        (tmp_path / word).write_text(said)
        text = text.replace(f"cat {word}", f"cat {tmp_path / word}")
    async with (
        fake_hub(addresses_of) as hub,
        running(hub.url, tmp_path / "data", text, file=tmp_path / "site.yaml"),
    ):
        await hub.until(lambda: 1.0 in hub.values("w/alarm"), "a state over states")
        assert hub.values("w/spread")[-1] == 2.5
        (tmp_path / "DEW").write_text("2.5")
        await hub.until(lambda: hub.values("w/twice")[-1:] == [20.0], "a value of a new input")
        # The file changes: what is worked out follows without a new start.
        changed = text.replace("{w/spread} * 2", "{w/spread} * 3")
        (tmp_path / "site.yaml").write_text(changed)
        await hub.until(lambda: hub.values("w/twice")[-1:] == [30.0], "the new expression")
