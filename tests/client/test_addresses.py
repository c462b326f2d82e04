"""Addresses, moments and settings of scripts: what is meant, and what cannot be."""

from __future__ import annotations

import contextlib
from datetime import UTC, datetime, timedelta, timezone

import pytest
from hypothesis import given, settings, strategies as st
from many_examples import examples

from talaia.client.addresses import channels_of, match_sites, qualify_address
from talaia.client.errors import BadSettings, ClientError, NotFound
from talaia.client.hub_location import HubLocation, find_hub
from talaia.client.times import parse_moment
from talaia.client.values import DeviceInfo, SignalInfo, SiteInfo, time_of

pytestmark = pytest.mark.pure

NOW = datetime(2026, 5, 1, 20, tzinfo=UTC)
POSE = SignalInfo(
    address="base/pose", name="Pose", type="position", channels=["base/pose.x", "base/pose.y"]
)
SPEED = SignalInfo(
    address="base/speed", name="Speed", type="number", unit="m/s", channels=["base/speed"]
)
SITE = SiteInfo(
    site="agv", name="Agv", devices=[DeviceInfo(id="base", name="Base", signals=[POSE, SPEED])]
)


def test_address_has_its_site_or_there_is_one_alone() -> None:
    assert qualify_address("agv/base/speed", []) == "agv/base/speed"
    assert qualify_address("base/speed", ["agv"]) == "agv/base/speed"
    assert qualify_address("agv/*", ["agv"]) == "agv/*"
    assert qualify_address("base/*", ["agv"]) == "agv/base/*"
    assert qualify_address("base", ["agv"], parts=2) == "agv/base"
    for wrong in ("speed", "a/b/c/d", "agv//speed", "/base/speed", ""):
        with pytest.raises(BadSettings, match="expected site/device/name"):
            qualify_address(wrong, ["agv"])
    with pytest.raises(BadSettings, match="one of a, b"):
        qualify_address("base/speed", ["a", "b"])


def test_signal_means_all_of_its_channels_and_each_comes_once() -> None:
    found = channels_of(SITE, ["agv/base/speed", "agv/base/*", "agv/base/pose.x"])
    assert [channel.channel for channel in found] == ["base/speed", "base/pose.x", "base/pose.y"]
    assert [channel.unit for channel in found] == ["m/s", "m", "m"]
    with pytest.raises(NotFound, match="did you mean agv/base/speed"):
        channels_of(SITE, ["agv/base/sped"])
    assert channels_of(SITE, ["moon/base/speed", "agv/base/x*"]) == []
    assert match_sites(["*/base/speed"], ["agv", "moon"]) == ["agv", "moon"]
    with pytest.raises(NotFound, match="no site 'mars'"):
        match_sites(["mars/base/speed"], ["agv"])


def test_moments_are_read_in_every_form_that_is_documented() -> None:
    epoch = datetime.fromtimestamp(0, UTC)
    for said, meant in (
        ("now", NOW),
        ("90s", NOW - timedelta(seconds=90)),
        ("-2h", NOW - timedelta(hours=2)),
        ("1.5d", NOW - timedelta(days=1.5)),
        ("2026-05-01T20:00Z", NOW),
        ("2026-05-01 20:00", NOW),
        ("2026-05-01T22:00+02:00", NOW),
        (NOW.astimezone(timezone(timedelta(hours=5))), NOW),
        (NOW.timestamp(), NOW),
    ):
        assert parse_moment(said, NOW) == (meant - epoch) // timedelta(microseconds=1)
    for wrong in ("yesterday", "2x", "", datetime(2026, 5, 1), float("nan"), 1e300, -1.0, "9999w"):  # noqa: DTZ001
        with pytest.raises(BadSettings):
            parse_moment(wrong, NOW)


@settings(max_examples=examples(25, many=1000))
@given(st.text(max_size=30))
def test_no_text_as_a_moment_an_address_or_a_hub_raises_anything_but_a_sentence(text) -> None:
    for read in (
        lambda: parse_moment(text, NOW),
        lambda: qualify_address(text, ["agv"]),
        lambda: HubLocation.from_text(text, "tal_x"),
    ):
        # Nothing else gets out, which would end a script without a sentence.
        with contextlib.suppress(ClientError):
            read()


@settings(max_examples=examples(12, many=500))
@given(st.integers(0, 2**53))
def test_times_keep_their_microseconds(time_us) -> None:
    assert parse_moment(time_of(time_us), NOW) == time_us


def test_hub_is_told_by_argument_environment_and_a_file_that_only_its_owner_reads(
    tmp_path,
) -> None:
    kept = tmp_path / "talaia" / "client.toml"
    kept.parent.mkdir()
    kept.write_text('hub = "https://hub.example:8443"\ntoken = "tal_kept"\nca = "/ca.pem"\n')
    said = {"XDG_CONFIG_HOME": str(tmp_path)}
    with pytest.raises(BadSettings, match="chmod 600"):
        find_hub(environment=said)
    kept.chmod(0o600)
    found = find_hub(environment=said)
    assert (found.page, found.token, str(found.ca)) == (
        "https://hub.example:8443",
        "tal_kept",
        "/ca.pem",
    )
    assert "tal_kept" not in repr(found)
    # Another hub is never shown this one's token.
    with pytest.raises(BadSettings, match="no token"):
        find_hub("https://other.example", environment=said)
    assert find_hub("https://a.example", "tal_a", environment=said).token == "tal_a"  # noqa: S105
    told = find_hub(environment={**said, "TALAIA_TOKEN": "tal_b", "TALAIA_FINGERPRINT": "AB" * 32})
    assert (told.token, told.fingerprint, told.ca) == ("tal_b", "ab" * 32, None)
    kept.write_text("hub = 3\n")
    with pytest.raises(BadSettings, match="quotation marks"):
        find_hub(environment=said)


def test_plain_text_is_for_loopback_alone() -> None:
    assert HubLocation.from_text("http://127.0.0.1:8080", "tal_x").plain
    assert HubLocation.from_text("hub.example", "tal_x").socket_url == "wss://hub.example:443"
    for hub, why in (
        ("http://hub.example", "plain text"),
        ("ws://10.0.0.1:1", "plain text"),
        ("ftp://a", "expected https"),
        ("https://a:99999", "expected https"),
    ):
        with pytest.raises(BadSettings, match=why):
            HubLocation.from_text(hub, "tal_x")
    with pytest.raises(BadSettings, match="characters that no token has"):
        HubLocation.from_text("https://a", "tal_x\r\nHost: b")
    with pytest.raises(BadSettings, match="64 hexadecimal"):
        HubLocation.from_text("https://a", "tal_x", fingerprint="abc")
