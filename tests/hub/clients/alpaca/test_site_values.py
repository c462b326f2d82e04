"""What a site says to clients that know no ages: safe only when everything that judges says so."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given, strategies as st

from talaia.clock import SECOND
from talaia.hub.auth.permissions import Grants, Permission, Right
from talaia.hub.clients.alpaca.device_answers import (
    NOT_IMPLEMENTED,
    VALUE_NOT_SET,
    AlpacaDevice,
    DeviceError,
    alpaca_devices,
    answer_property,
)
from talaia.hub.clients.alpaca.site_values import SiteValues
from talaia.hub.live.site_state import LinkedGateway
from talaia.hub.live.sites import LiveSite, Sites
from talaia.model.yaml_text.load import load_site
from talaia.wire.columns import Columns
from talaia.wire.frames import InterlockState

from .observatory_site import OBSERVATORY

if TYPE_CHECKING:
    from talaia.wire.frames import FromHub

NOW_NS = 1000 * SECOND


class NoLink:
    """A link that carries nothing."""

    def send(self, message: FromHub) -> None: ...

    def dismiss_gateway(self, reason: str) -> None: ...


def grants_of(*rights: Right) -> Grants:
    return Grants(frozenset(Permission(right) for right in rights))


def fine_site() -> LiveSite:
    """A site that is safe: all is known, and nothing speaks against it."""
    live = Sites().describe_site(load_site(OBSERVATORY), "c")
    live.attach_link(NoLink(), LinkedGateway(), 1)
    for address, value in (
        ("dome/shutter", 0.0),
        ("dome/azimuth", 361.5),
        ("weather/wind", 36.0),
        ("weather/temperature", -3.0),
        ("weather/status", 0.0),
    ):
        set_value(live, address, value)
    live.current.interlocks["rain"] = (InterlockState(interlock="rain", locked=False), NOW_NS)
    return live


def set_value(live: LiveSite, address: str, value: float, age_s: float = 0.0) -> None:
    at = [channel.address for channel in live.channels].index(address)
    columns = Columns(
        np.array([at], np.uint16), np.array([1], np.int64), np.array([value], np.float64), {}
    )
    live.latest.update_values(columns, NOW_NS - round(age_s * SECOND))


def values_of(live: LiveSite, *rights: Right) -> SiteValues:
    return SiteValues(live, grants_of(*(rights or (Right.VIEW,))), NOW_NS)


def answer(live: LiveSite, kind: str, name: str, **arguments: str) -> object:
    values = values_of(live)
    device = next(one for one in alpaca_devices(values) if one.type == kind)
    return answer_property(device, name, arguments, values=values, permits=lambda *_: False)


def error_of(live: LiveSite, kind: str, name: str, **arguments: str) -> int:
    with pytest.raises(DeviceError) as raised:
        answer(live, kind, name, **arguments)
    return raised.value.number


def test_a_site_of_which_all_is_known_and_fine_is_safe() -> None:
    assert answer(fine_site(), "safetymonitor", "issafe") is True


@given(st.sampled_from([1.0, 2.0, 3.0, -1.0, float("nan"), float("inf")]))
def test_a_weather_that_says_anything_but_safe_is_unsafe(value: float) -> None:
    live = fine_site()
    set_value(live, "weather/status", value)
    assert answer(live, "safetymonitor", "issafe") is False


def test_it_is_unsafe_when_anything_that_judges_is_stale_unknown_or_away() -> None:
    stale, away, unreached, silent, locked, blind = (fine_site() for _ in range(6))
    set_value(stale, "weather/status", 0.0, age_s=6)
    away.detach_link(2)
    unreached.current.unreached["weather"] = ("off", 1)
    silent.current.interlocks.clear()
    locked.current.interlocks["rain"] = (InterlockState(interlock="rain", locked=True), NOW_NS)
    blind.current.interlocks["rain"] = (
        InterlockState(interlock="rain", locked=False, unknown=("weather/status",)),
        NOW_NS,
    )
    for live in (stale, away, unreached, silent, locked, blind):
        assert answer(live, "safetymonitor", "issafe") is False
        assert values_of(live).unsafe_reason()


def test_an_overridden_interlock_is_unsafe_to_programs() -> None:
    live = fine_site()
    state = InterlockState(interlock="rain", locked=True, overridden_by="Ada", reason="test")
    live.current.interlocks["rain"] = (state, NOW_NS)
    assert answer(live, "safetymonitor", "issafe") is False


def test_a_site_without_anything_that_judges_is_never_safe() -> None:
    bare = OBSERVATORY[: OBSERVATORY.index("  weather:")]
    live = Sites().describe_site(load_site(bare), "c")
    live.attach_link(NoLink(), LinkedGateway(), 1)
    assert values_of(live).unsafe_reason() == "the site has nothing that judges safety"


def test_safety_counts_what_the_account_may_not_see() -> None:
    live = fine_site()
    set_value(live, "weather/status", 2.0)
    blind = SiteValues(live, Grants(frozenset()), NOW_NS)
    assert "weather/status" in blind.unsafe_reason()
    # And nothing else of what it may not see is served.
    assert [device.type for device in alpaca_devices(blind)] == ["safetymonitor"]


def test_values_are_in_ascoms_units_and_numbers() -> None:
    live = fine_site()
    assert answer(live, "observingconditions", "windspeed") == pytest.approx(10.0)
    assert answer(live, "observingconditions", "temperature") == -3.0
    assert answer(live, "dome", "azimuth") == pytest.approx(1.5)
    assert [answer_shutter(live, value) for value in (0.0, 1.0, 2.0, 3.0, 4.0)] == [1, 0, 2, 3, 4]


def answer_shutter(live: LiveSite, value: float) -> object:
    set_value(live, "dome/shutter", value)
    return answer(live, "dome", "shutterstatus")


def test_what_is_not_known_is_an_error_and_no_number() -> None:
    live = fine_site()
    set_value(live, "dome/shutter", float("nan"))
    set_value(live, "weather/wind", 5.0, age_s=6)
    assert error_of(live, "dome", "shutterstatus") == VALUE_NOT_SET
    assert error_of(live, "observingconditions", "windspeed") == VALUE_NOT_SET
    assert error_of(live, "observingconditions", "humidity") == NOT_IMPLEMENTED
    live.detach_link(2)
    assert error_of(live, "dome", "azimuth") == VALUE_NOT_SET
    assert error_of(live, "observingconditions", "temperature") == VALUE_NOT_SET


def test_a_sensor_tells_its_age() -> None:
    live = fine_site()
    set_value(live, "weather/wind", 5.0, age_s=2)
    age = answer(live, "observingconditions", "timesincelastupdate", sensorname="WindSpeed")
    assert age == pytest.approx(2.0)


def test_devices_are_numbered_in_their_type() -> None:
    assert alpaca_devices(values_of(fine_site())) == [
        AlpacaDevice("dome", 0, "Dome", "dome"),
        AlpacaDevice("observingconditions", 0, "Weather", "weather"),
        AlpacaDevice("safetymonitor", 0, "Safety of Roof", ""),
    ]
