"""What a changed description means for single parts of a gateway: pure, by hand-moved clocks."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec import structs

from talaia.clock import SECOND
from talaia.gateway.accepted_changes import AcceptedChanges
from talaia.gateway.change_policy import forbidden_changes
from talaia.gateway.errors import ChannelNumbersFull
from talaia.gateway.ports import ChannelReading
from talaia.gateway.safety.interlocks import Interlocks
from talaia.gateway.samples.channel_numbering import ChannelNumbering
from talaia.gateway.spool.files import SegmentHead
from talaia.gateway.spool.journal import Spool, SpoolPosition
from talaia.gateway.uplink.catchup import as_old
from talaia.model.renames import list_renames
from talaia.model.yaml_text.load import load_site
from talaia.wire.columns import Columns, renumber_channels
from talaia.wire.errors import PeerError
from talaia.wire.frames import LINK_FROM_GATEWAY, SampleBatch
from talaia.wire.sealing import MAX_TEXT, compress_text, decompress_text, seal_of

pytestmark = pytest.mark.pure

SOURCE = "{topic: /x, type: std_msgs/msg/Float64, field: data}"
TEXT = f"""talaia: 1
site: dome
name: Dome
connections:
  ros: {{kind: ros2}}
  shell: {{kind: process}}
devices:
  weather:
    name: Weather
    connection: ros
    signals:
      wind: {{name: Wind, unit: m/s, source: {SOURCE}}}
      rain: {{name: Rain, source: {SOURCE}}}
  dome:
    name: Dome
    connection: ros
    commands:
      open: {{name: Open, target: /open, type: std_srvs/srv/Trigger}}
  tool:
    name: Tool
    connection: shell
    signals:
      load: {{name: Load, source: {{run: "uptime"}}}}
interlocks:
  storm:
    name: Storm
    when: [{{signal: weather/wind, above: 10}}]
    refuse: [dome/open]
    dwell: 60
    longest_override: 600
"""
BEFORE = load_site(TEXT)


def changed(*pairs: tuple[str, str]) -> object:
    text = TEXT
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    return load_site(text)


def test_channel_keeps_its_number_whatever_comes_and_goes_around_it() -> None:
    roster = ChannelNumbering(BEFORE)
    rain = roster.numbers_of(BEFORE)["weather/rain"]
    after = changed(("      wind:", f"      gust: {{name: G, source: {SOURCE}}}\n      wind:"))
    roster.add_channels(after, {})
    assert roster.numbers_of(after)["weather/rain"] == rain
    columns = Columns(np.array([rain, 0], np.uint16), np.zeros(2, np.int64), np.ones(2), {})
    shown = renumber_channels(columns, roster.order_of(after))
    addresses = [each.address for each in after.channels()]
    assert [addresses[each] for each in shown.channel] == ["weather/rain", "weather/wind"]


def test_renamed_channel_keeps_its_number_and_a_removed_one_has_no_place() -> None:
    roster = ChannelNumbering(BEFORE)
    wind, rain = (roster.numbers_of(BEFORE)[f"weather/{each}"] for each in ("wind", "rain"))
    after = changed(
        ("      wind: {", "      gale: {was: wind, "), ("weather/wind", "weather/gale"),
        (f"      rain: {{name: Rain, source: {SOURCE}}}\n", ""),
    )  # fmt: skip
    roster.add_channels(after, list_renames(BEFORE, after))
    assert roster.numbers_of(after)["weather/gale"] == wind
    columns = Columns(
        np.array([rain, wind], np.uint16), np.arange(2), np.arange(2.0), {0: "gone", 1: "here"}
    )
    shown = renumber_channels(columns, roster.order_of(after))
    assert shown.value.tolist() == [1.0]
    assert shown.texts == {0: "here"}


def test_full_roster_says_so_and_stays_as_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("talaia.gateway.samples.channel_numbering.MOST", 3)
    roster = ChannelNumbering(BEFORE)
    after = changed(("      wind:", f"      gust: {{name: G, source: {SOURCE}}}\n      wind:"))
    with pytest.raises(ChannelNumbersFull):
        roster.add_channels(after, {})
    assert len(roster.order_of(BEFORE)) == 3


@pytest.mark.parametrize(
    ("change", "readings", "everything"),
    [
        (("name: Rain", "name: Drops"), True, True),
        (("      rain:", f"      dew: {{name: D, source: {SOURCE}}}\n      rain:"), True, True),
        # The interlock depends on what it reads, how old that may be, and what is possible at all.
        (("name: Wind, unit: m/s", "name: Wind, unit: m/s, maximum: 40"), False, True),
        (("name: Wind, unit: m/s", "name: Wind, unit: m/s, max_age: 500"), False, True),
        (("above: 10", "above: 90"), False, True),
        (("dwell: 60", "dwell: 1"), False, True),
        (("target: /open", "target: /close"), False, True),
        (("name: Weather", "name: Weather\n    visibility: public"), False, True),
        # Never: what runs beside the robot, how it is reached, whose it is.
        (("uptime", "reboot"), False, False),
        (("kind: ros2", "kind: ros2, domain: 7"), False, False),
        (("site: dome", "site: other"), False, False),
    ],
)
def test_hub_may_change_what_the_gateway_permits_and_no_more(
    change: tuple[str, str],
    readings: bool,  # noqa: FBT001
    everything: bool,  # noqa: FBT001
) -> None:
    after = changed(change)
    assert (not forbidden_changes(BEFORE, after, AcceptedChanges.READINGS)) is readings
    assert (not forbidden_changes(BEFORE, after, AcceptedChanges.ALL)) is everything
    assert forbidden_changes(BEFORE, after, AcceptedChanges.NO)


FENCED = load_site(
    TEXT.replace(
        "devices:\n",
        """map:
  zones:
    yard: {name: Yard, geometry: RING}
    pond: {name: Pond, geometry: RING}
devices:
""",
        1,
    )
    .replace("[{signal: weather/wind, above: 10}]", "[{signal: weather/fix, outside: yard}]")
    .replace("RING", "{type: Polygon, coordinates: [[[2, 41], [3, 41], [3, 42], [2, 41]]]}")
)


def moved(zone: str, **more: object):
    """Describe a zone with other keys."""
    known = FENCED.map.zones
    zones = {**known, zone: structs.replace(known[zone], **more)}
    return structs.replace(FENCED, map=structs.replace(FENCED.map, zones=zones))


def test_where_an_interlocks_zone_lies_is_changed_at_the_gateway_alone() -> None:
    other = structs.replace(FENCED.map.zones["yard"].geometry, coordinates=())
    refused = forbidden_changes(FENCED, moved("yard", geometry=other), AcceptedChanges.READINGS)
    assert [one.where for one in refused] == ["$.map.zones.yard"]
    # Its name is for people, and of another zone nothing is kept from anything.
    for harmless in (moved("yard", name="Court"), moved("pond", geometry=other)):
        assert not forbidden_changes(FENCED, harmless, AcceptedChanges.READINGS)


class World:
    """Readings, output and runner of interlocks, written down."""

    def __init__(self) -> None:  # noqa: D107
        self.value = 1.0
        self.now_ns = 0
        self.notes: list[str] = []

    def latest(self, address: str) -> ChannelReading | None:
        return ChannelReading(self.value, self.now_ns) if address == "weather/wind" else None

    def send(self, message: object) -> None: ...

    def record_event(self, kind: str, *_more: object, **_good: object) -> None:
        self.notes.append(kind)

    def run(self, label: str, _steps: object) -> None:
        self.notes.append(label)


def released(world: World) -> Interlocks:
    interlocks = Interlocks(site=BEFORE, readings=world, output=world, run=world.run, now_ns=0)
    for second in range(62):
        world.now_ns = second * SECOND
        interlocks.evaluate_all(world.now_ns)
    assert interlocks.refusal_reason("dome", "open", world.now_ns) == ""
    return interlocks


def test_interlock_that_is_described_as_it_was_goes_on_and_a_changed_one_begins_locked() -> None:
    world = World()
    interlocks = released(world)
    interlocks.redescribe(changed(("name: Rain", "name: Drops")), world.now_ns)
    assert interlocks.refusal_reason("dome", "open", world.now_ns) == ""
    interlocks.redescribe(changed(("above: 10", "above: 12")), world.now_ns)
    assert interlocks.refusal_reason("dome", "open", world.now_ns)


def test_interlock_of_a_sensor_that_nobody_has_heard_yet_is_locked_and_does_not_act() -> None:
    world = World()
    interlocks = released(world)
    world.now_ns = 100 * SECOND
    added = "interlocks:\n  wet: {name: Wet, when: [{signal: weather/rain, above: 0}], " \
        "refuse: [dome/open], run: [{command: dome/open}]}"  # fmt: skip
    interlocks.redescribe(changed(("interlocks:", added)), world.now_ns)
    interlocks.evaluate_all(world.now_ns + SECOND)
    assert "Wet" in interlocks.refusal_reason("dome", "open", world.now_ns + SECOND)
    assert "interlock wet" not in world.notes


def batch(first: int, catalogue: str) -> object:
    from talaia.gateway.samples.batching import records_of

    columns = Columns(np.zeros(1, np.uint16), np.array([first]), np.ones(1), {})
    return records_of(columns, "b", catalogue, first)[0]


def test_spool_keeps_each_batch_by_the_list_of_its_time(tmp_path) -> None:
    spool = Spool(folder=tmp_path, head=SegmentHead("b", "old", ["a/x"]), bound=10**7)
    spool.append_record(batch(0, "old"))
    spool.redescribe(SegmentHead("b", "new", ["a/y"]))
    spool.append_record(batch(1, "new"))
    found, place = spool.read_records(SpoolPosition(), 10**6)
    found += spool.read_records(place, 10**6)[0]
    frames = [LINK_FROM_GATEWAY.decode(as_old(each, "new")) for each in found]
    assert all(isinstance(each, SampleBatch) for each in frames)
    assert [(each.first, each.addresses) for each in frames] == [(0, ["a/x"]), (1, [])]
    spool.close()


def test_description_that_unpacks_to_more_than_it_may_is_refused() -> None:
    assert decompress_text(compress_text("site: ✓")) == "site: ✓"
    with pytest.raises(PeerError):
        decompress_text(compress_text("a" * (MAX_TEXT + 1)))
    with pytest.raises(PeerError):
        decompress_text(b"no")


def test_seal_holds_each_part_of_a_change_by_itself() -> None:
    key = "ab" * 32
    one = seal_of(key, change_id="a", who="bc", base="0" * 64, text="text")
    assert one != seal_of(key, change_id="ab", who="c", base="0" * 64, text="text")
    assert one != seal_of(key, change_id="a", who="bc", base="0" * 64, text="texts")
