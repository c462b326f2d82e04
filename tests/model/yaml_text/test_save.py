"""A description that was changed by a form keeps what its author wrote round it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import msgspec
import pytest
from hypothesis import given, settings, strategies as st
from many_examples import examples

from talaia.model.connection import RosSource
from talaia.model.errors import DescriptionError
from talaia.model.site import Device, Drive, Ros2Settings, Signal, SignalType, Site
from talaia.model.yaml_text.load import dump_site, load_site
from talaia.model.yaml_text.save import save_into_text
from talaia.model.yaml_text.write import write_description

AGV = (Path(__file__).parents[3] / "examples/agv/site.yaml").read_text()
replace = msgspec.structs.replace


def with_speed(site: Site, **changes: object) -> Site:
    base = site.devices["base"]
    speed = replace(base.signals["speed"], **changes)
    signals = {**base.signals, "speed": speed}
    return replace(site, devices={**site.devices, "base": replace(base, signals=signals)})


def test_a_description_that_was_not_changed_is_the_same_text() -> None:
    assert save_into_text(AGV, load_site(AGV)) == AGV


def test_one_changed_limit_changes_one_line() -> None:
    after = save_into_text(AGV, with_speed(load_site(AGV), maximum=0.5))
    changed = set(after.splitlines()) - set(AGV.splitlines())
    assert len(changed) == 1
    assert "maximum: 0.5" in changed.pop()
    assert after.startswith("# The simulated vehicle of `talaia demo`")


def test_what_goes_back_to_its_default_is_no_longer_written() -> None:
    after = save_into_text(AGV, with_speed(load_site(AGV), minimum=None))
    assert after.count("minimum:") == AGV.count("minimum:") - 1


def test_a_removed_device_goes_and_the_comments_of_the_others_stay() -> None:
    text = AGV.replace("  power:\n", "  # bought in May\n  power:\n").replace(
        "  sensors:\n", "  # glued on\n  sensors:\n"
    )
    site = load_site(text)
    rest = {key: each for key, each in site.devices.items() if key != "sensors"}
    after = save_into_text(text, replace(site, devices=rest))
    assert "# bought in May" in after
    assert set(load_site(after).devices) == set(rest)


def test_a_new_order_of_devices_is_written() -> None:
    site = load_site(AGV)
    turned = replace(site, devices=dict(reversed(site.devices.items())))
    assert list(load_site(save_into_text(AGV, turned)).devices) == list(turned.devices)


def test_a_text_that_is_no_description_is_refused() -> None:
    with pytest.raises(DescriptionError):
        save_into_text("talaia: 2", load_site(AGV))


texts = st.text(min_size=1, max_size=12)
words = st.from_regex(r"[a-z][a-z0-9_]{0,8}", fullmatch=True)
sources = st.builds(RosSource, topic=texts, type=texts, field=texts)
signals = st.builds(
    Signal,
    name=texts,
    source=sources,
    type=st.sampled_from(SignalType),
    unit=texts,
    minimum=st.none() | st.floats(allow_nan=False, allow_infinity=False),
    states=st.lists(texts, max_size=3).map(tuple),
    primary=st.booleans(),
)
drives = st.builds(Drive, topic=texts, max_speed=st.floats(0.1, 9), max_turn=st.floats(0.1, 9))
devices = st.builds(
    Device,
    name=texts,
    signals=st.dictionaries(words, signals, max_size=3),
    drive=st.none() | drives,
)
sites = st.builds(
    Site,
    talaia=st.just(1),
    site=words,
    name=texts,
    ros2=st.none() | st.builds(Ros2Settings, domain=st.none() | st.integers(0, 9)),
    devices=st.dictionaries(words, devices, max_size=3),
)


@settings(deadline=None, max_examples=examples(10, many=250))
@given(sites, sites, st.sampled_from([write_description, dump_site]))
def test_any_change_of_any_description_reads_back_as_it_was_meant(
    before: Site, after: Site, write: Callable[[Site], str]
) -> None:
    text = write(before)
    read = load_site(save_into_text(text, after))
    assert read == after
    assert list(read.devices) == list(after.devices)
