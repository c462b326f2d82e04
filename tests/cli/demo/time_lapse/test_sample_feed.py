"""What people who look on are told of an observatory that lives faster than they do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from talaia.cli.demo.in_process_observatory import InProcessObservatory
from talaia.cli.demo.time_lapse.lapse_site import lapse_site
from talaia.cli.demo.time_lapse.sample_feed import SampleFeed
from talaia.clock import SECOND, HandClock
from talaia.gateway.samples.channel_numbering import ChannelNumbering
from talaia.model.yaml_text.load import load_site
from talaia.wire.columns import Columns

pytestmark = pytest.mark.pure
EXAMPLE = Path(__file__).parents[4] / "examples" / "observatory" / "site.yaml"
NOW = 1_795_647_600


class Heard:
    """A `SampleSink` that keeps what it is given."""

    def __init__(self) -> None:  # noqa: D107
        self.batches: list[Columns] = []

    def put_samples(self, columns: Columns) -> None:
        self.batches.append(columns)


def test_everything_is_said_with_its_own_time_and_a_state_as_soon_as_it_changes() -> None:
    site = lapse_site(load_site(EXAMPLE.read_text()), NOW)
    clock, heard = HandClock(NOW * SECOND), Heard()
    robot = InProcessObservatory(site, clock, seed=1)
    numbers = ChannelNumbering(site).numbers_of(site)
    feed = SampleFeed(site, numbers, heard)
    robot.step()
    feed.give_values(robot, NOW * 1_000_000)
    (whole,) = heard.batches
    channels = site.channels()
    said = {channels[at].address for at in whole.channel}
    assert {"dome/shutter", "weather/wind", "focuser/position", "weather/description"} <= said
    assert set(whole.time_us.tolist()) == {NOW * 1_000_000}
    texts = [channels[whole.channel[at]].text for at in whole.texts]
    assert texts
    assert all(texts)
    # At once, whatever time it is for those who look on.
    opened: list[str] = []
    robot.act("dome", "open", {}, lambda outcome: opened.append(outcome.message))
    clock.advance(SECOND)
    robot.step()
    feed.give_values(robot, (NOW + 1) * 1_000_000)
    newest = heard.batches[-1]
    at = np.flatnonzero(newest.channel == numbers["dome/shutter"])
    assert site.devices["dome"].signals["shutter"].states[int(newest.value[at[0]])] == "opening"
