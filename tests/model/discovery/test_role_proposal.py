"""What a signal or command is: said in the description, or proposed for one of before roles."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from talaia.model.checks.site_checks import check_site
from talaia.model.discovery.command_file import site_of
from talaia.model.discovery.role_proposal import (
    meanings_of,
    place_arguments,
    roles_of,
    with_roles,
)
from talaia.model.roles import CommandRole, SignalRole
from talaia.model.yaml_text.load import dump_site, load_site, read_site

ROOT = Path(__file__).parents[3]
EXAMPLES = sorted(path.parent.name for path in (ROOT / "examples").glob("*/site.yaml"))
COMMAND_FILE = ROOT / "tests" / "wire" / "recorded" / "observatory_commands.json"

# By site and device: what a page finds there. `without_roles` below makes descriptions of before.
PROPOSED = {
    "observatory/dome": {
        "shutter": "dome.shutter",
        "position": "dome.opening",
        "azimuth": "dome.azimuth",
        "turning": "dome.turning",
        "local": "dome.local",
        "open()": "dome.open",
        "close()": "dome.close",
        "stop()": "dome.stop",
        "park()": "dome.park",
        "goto()": "dome.goto",
    },
    "observatory/telescope": {
        "state": "telescope.state",
        "ra": "telescope.ra",
        "dec": "telescope.dec",
        "altitude": "telescope.altitude",
        "azimuth": "telescope.azimuth",
        "goto()": "telescope.goto",
        "track()": "telescope.track",
        "unpark()": "telescope.unpark",
        "park()": "telescope.park",
        "stop()": "telescope.stop",
    },
    "observatory/weather": {
        "clouds": "weather.clouds",
        "raining": "weather.raining",
        "rain": "weather.rain",
        "wind": "weather.wind",
        "gust": "weather.gust",
        "humidity": "weather.humidity",
        "dew_point": "weather.dew_point",
        "temperature": "weather.temperature",
        "pressure": "weather.pressure",
    },
    "observatory/camera": {
        "state": "camera.state",
        "remaining": "camera.remaining",
        "temperature": "camera.temperature",
        "cooling": "camera.cooler",
        "expose()": "camera.expose",
        "dark()": "camera.expose",
        "cool()": "camera.cool",
        "abort()": "camera.abort",
        "cooler()": "camera.cooler",
        "binning": "camera.binning",
        "gain": "camera.gain",
        "bias()": "camera.expose",
        "flat()": "camera.expose",
        "binning()": "camera.binning",
        "gain()": "camera.gain",
    },
    "observatory/focuser": {
        "position": "focuser.position",
        "moving": "focuser.moving",
        "temperature": "focuser.temperature",
        "goto()": "focuser.goto",
        "move()": "focuser.move",
        "stop()": "focuser.stop",
    },
    "observatory/wheel": {
        "position": "camera.filter",
        "select()": "camera.filter",
    },
    "observatory/power": {
        **{f"outlet{number}": "power.outlet" for number in range(1, 9)},
        **{f"outlet{number}()": "power.switch" for number in range(1, 9)},
        "total": "power.total",
    },
    "observatory/cctv": {},
    "indi/dome": {
        "shutter": "dome.shutter",
        "parked": "dome.parked",
        "azimuth": "dome.azimuth",
        "open()": "dome.open",
        "close()": "dome.close",
        "stop()": "dome.stop",
        "goto()": "dome.goto",
        "park()": "dome.park",
        "unpark()": "dome.unpark",
    },
    "indi/telescope": {
        "ra": "telescope.ra",
        "dec": "telescope.dec",
        "parked": "telescope.parked",
        "tracking": "telescope.tracking",
        "goto()": "telescope.goto",
        "stop()": "telescope.stop",
        "track()": "telescope.track",
        "untrack()": "telescope.untrack",
        "park()": "telescope.park",
        "unpark()": "telescope.unpark",
    },
    "indi/camera": {
        "state": "camera.state",
        "exposure": "camera.remaining",
        "temperature": "camera.temperature",
        "binning": "camera.binning",
        "gain": "camera.gain",
        "filter": "camera.filter",
        "expose()": "camera.expose",
        "dark()": "camera.expose",
        "flat()": "camera.expose",
        "abort()": "camera.abort",
        "cool()": "camera.cool",
        "binning()": "camera.binning",
        "gain()": "camera.gain",
        "filter()": "camera.filter",
    },
    "indi/weather": {
        "safety": "weather.safety",
        "wind": "weather.wind",
        "gust": "weather.gust",
        "temperature": "weather.temperature",
        "rain": "weather.rain",
    },
    "indi/station": {"humidity": "weather.humidity", "temperature": "weather.temperature"},
    "clamshell/dome": {
        "shutter": "dome.shutter",
        "position": "dome.opening",
        "local": "dome.local",
        "open()": "dome.open",
        "close()": "dome.close",
        "stop()": "dome.stop",
    },
    "agv/base": {
        "speed": "vehicle.speed",
        "turn_rate": "vehicle.turn_rate",
        "pose": "vehicle.position",
    },
    "agv/power": {"charge": "battery.level", "voltage": "battery.voltage"},
    "agv/sensors": {},
    "agv/camera": {},
}


def example(name):
    return read_site(ROOT / "examples" / name / "site.yaml")


def without_roles(device):
    """Give a device as it was described before there were roles."""
    replace = msgspec.structs.replace
    return replace(
        device,
        signals={
            name: replace(signal, role=SignalRole.AUTO, meanings=())
            for name, signal in device.signals.items()
        },
        commands={
            name: replace(command, role=CommandRole.AUTO)
            for name, command in device.commands.items()
        },
    )


def table_of(device) -> dict[str, str]:
    roles = roles_of(device)
    commands = {f"{name}()": role.value for name, role in roles.commands.items()}
    return {name: role.value for name, role in roles.signals.items()} | commands


def device_of(kind: str, text: str):
    """Describe one ROS device by its keys in YAML's short form."""
    return load_site(
        "talaia: 1\nsite: a\nname: A\nros2: {}\n"
        f"devices: {{it: {{name: Anything, kind: {kind}, {text}}}}}"
    ).devices["it"]


def signals(**described: str) -> str:
    source = "source: {topic: /t, type: std_msgs/msg/Float64, field: data}"
    keys = ", ".join(
        f"{name}: {{name: {name}, {said}, {source}}}" for name, said in described.items()
    )
    return f"signals: {{{keys}}}"


def commands(**described: str) -> str:
    keys = ", ".join(
        f"{name}: {{name: {name}, target: /t, type: std_srvs/srv/Trigger, arguments: {{{said}}}}}"
        for name, said in described.items()
    )
    return f"commands: {{{keys}}}"


@pytest.mark.parametrize("where", sorted(PROPOSED))
def test_a_description_of_before_roles_is_given_those_that_its_pages_need(where: str) -> None:
    site, _, device = where.partition("/")
    assert table_of(without_roles(example(site).devices[device])) == PROPOSED[where]


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_examples_say_every_role_that_is_proposed(name: str) -> None:
    site = example(name)
    assert check_site(site) == []
    for device in site.devices.values():
        assert table_of(device) == table_of(without_roles(device))
        assert with_roles(device) == device


@pytest.mark.parametrize("name", EXAMPLES)
def test_whatever_is_proposed_passes_the_checks_and_is_written_and_read_again(name: str) -> None:
    site = example(name)
    devices = {key: with_roles(without_roles(device)) for key, device in site.devices.items()}
    proposed = msgspec.structs.replace(site, devices=devices)
    assert check_site(proposed) == []
    assert load_site(dump_site(proposed)) == proposed


def test_a_command_files_devices_have_roles() -> None:
    site = site_of(COMMAND_FILE.read_text(), "observatory")
    assert site.devices["dome"].signals["status"].role is SignalRole.DOME_SHUTTER
    telescope = site.devices["telescope"]
    assert telescope.signals["altitude"].role is SignalRole.TELESCOPE_ALTITUDE
    assert telescope.commands["goto"].role is CommandRole.TELESCOPE_GOTO


def test_what_is_said_wins_and_none_stays_without() -> None:
    device = device_of(
        "dome",
        signals(
            shutter="type: state, states: [closed, open], role: none",
            roof="type: state, states: [closed, open]",
            azimuth="unit: °",
            heading="unit: °, role: dome.azimuth",
        ),
    )
    assert table_of(device) == {"heading": "dome.azimuth", "roof": "dome.shutter"}


def test_a_dome_in_catalan_has_its_roles_when_it_says_them() -> None:
    text = signals(
        comporta="type: state, states: [tancada, oberta, obrint, aturada], role: dome.shutter, "
        "meanings: [closed, open, opening, partial]",
        gir="unit: °, role: dome.azimuth",
    )
    device = device_of(
        "dome",
        text + ", " + commands(obre="").replace("{name: obre", "{name: Obre, role: dome.open"),
    )
    assert table_of(device) == {
        "comporta": "dome.shutter",
        "gir": "dome.azimuth",
        "obre()": "dome.open",
    }
    shutter = device.signals["comporta"]
    assert meanings_of(shutter, SignalRole.DOME_SHUTTER) == ("closed", "open", "opening", "partial")
    assert table_of(without_roles(device)) == {}


def test_every_english_word_of_a_shutter_means_something_and_what_none_knows_is_unknown() -> None:
    words = "opened, open, closed, opening, closing, stopped, error, unknown, humming"
    shutter = device_of("dome", signals(it=f"type: state, states: [{words}]")).signals["it"]
    assert meanings_of(shutter, SignalRole.DOME_SHUTTER) == (
        *("open", "open", "closed", "opening", "closing", "partial", "error", "unknown"),
        "unknown",
    )


def test_a_state_of_any_signal_that_is_called_an_error_means_one() -> None:
    states = "type: state, states: [idle, Warning, '[ERROR] no answer', unknown, warned]"
    mode = device_of("other", signals(it=states)).signals["it"]
    expected = ("normal", "warning", "error", "unknown", "normal")
    for role in (None, SignalRole.DOME_PARKED):
        assert meanings_of(mode, role) == expected
    states = "type: state, states: [shut, ajar, unknown]"
    calm = device_of("other", signals(it=states)).signals["it"]
    assert meanings_of(calm, None) == ()


def test_the_states_of_any_signal_mean_what_is_said_in_any_language() -> None:
    states = "type: state, states: [bé, avaria], meanings: [normal, error]"
    mode = device_of("other", signals(it=states)).signals["it"]
    assert meanings_of(mode, None) == ("normal", "error")


def test_a_station_that_warns_is_neither_safe_nor_unsafe() -> None:
    states = "type: state, states: [unknown, safe, Warning, unsafe, fine]"
    safety = device_of("weather", signals(it=states)).signals["it"]
    expected = ("unknown", "safe", "warning", "unsafe", "safe")
    assert meanings_of(safety, SignalRole.WEATHER_SAFETY) == expected


def test_buttons_open_and_close_the_shutter_never_the_flap() -> None:
    device = device_of("dome", commands(open_flap="", close_flap="", open="", close="", stop=""))
    assert table_of(device) == {
        "open()": "dome.open",
        "close()": "dome.close",
        "stop()": "dome.stop",
    }


def test_a_page_goes_by_what_a_device_is_never_by_what_it_is_called() -> None:
    text = signals(shutter="type: state, states: [closed, open]")
    assert table_of(device_of("other", text)) == {}


def test_the_suns_altitude_is_not_the_telescopes() -> None:
    device = device_of("telescope", signals(sun_altitude="unit: °", altitude="unit: °"))
    assert table_of(device) == {"altitude": "telescope.altitude"}


PLACE = "ra: {type: number, field: a, unit: h}, dec: {type: number, field: b, unit: °}"


def test_a_command_with_right_ascension_and_declination_points_it_and_a_sync_never_does() -> None:
    device = device_of("telescope", commands(sync=PLACE, goto=PLACE))
    assert place_arguments(device, roles_of(device)) == ("goto", "ra", "dec")
    device = device_of("telescope", commands(sync=PLACE))
    assert place_arguments(device, roles_of(device)) is None


def test_the_description_says_which_command_points_a_telescope_by_whatever_name() -> None:
    other = PLACE.replace("ra:", "a:").replace("dec:", "d:")
    pointing = "pointing: {commands: {hin: {ra: a, dec: d}}}"
    device = device_of("telescope", commands(hin=other) + ", " + pointing)
    assert place_arguments(device, roles_of(device)) == ("hin", "a", "d")


def test_a_role_alone_makes_the_first_number_right_ascension_and_the_second_declination() -> None:
    other = PLACE.replace("ra:", "ascensio:").replace("dec:", "declinacio:")
    text = commands(apunta=other).replace("{name: apunta", "{name: Apunta, role: telescope.goto")
    device = device_of("telescope", text)
    assert place_arguments(device, roles_of(device)) == ("apunta", "ascensio", "declinacio")


def test_an_outlet_is_a_state_of_off_and_on_with_the_switch_of_its_own_id() -> None:
    device = device_of(
        "power",
        signals(
            lamp='type: state, states: ["off", "on"]',
            fan='type: state, states: ["off", "on"]',
            mode="type: state, states: [eco, full, boost]",
            total="unit: W",
        )
        + ", "
        + commands(lamp="active: {type: boolean, field: data}", fan_on="", fan_off=""),
    )
    assert table_of(device) == {
        "lamp": "power.outlet",
        "fan": "power.outlet",
        "total": "power.total",
        "lamp()": "power.switch",
        "fan_on()": "power.on",
        "fan_off()": "power.off",
    }


def test_a_battery_is_known_by_its_message_at_whatever_device() -> None:
    device = device_of("other", signals(left="unit: '%'")).signals["left"]
    source = {"type": "sensor_msgs/msg/BatteryState", "field": "percentage"}
    left = msgspec.structs.replace(device, source=msgspec.structs.replace(device.source, **source))
    robot = msgspec.structs.replace(device_of("other", "signals: {}"), signals={"left": left})
    assert table_of(robot) == {"left": "battery.level"}
