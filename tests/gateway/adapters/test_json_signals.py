"""Values in JSON and plain text, as devices send them: what is read, and what is told."""

from __future__ import annotations

import json

import pytest
from hypothesis import given, strategies as st

from talaia.gateway.adapters.connection_scope import scopes_of
from talaia.gateway.adapters.json_signals import JsonSignals, parse_payload, signal_value
from talaia.gateway.errors import FieldError
from talaia.model.checks.site_checks import check_site
from talaia.model.connections.json_path import parse_json_path
from talaia.model.errors import DescriptionError
from talaia.model.site import Signal, SignalType
from talaia.model.yaml_text.load import load_site

pytestmark = pytest.mark.pure

NUMBER = {"type": SignalType.NUMBER}
STATE = {"type": SignalType.STATE, "states": ("OFF", "ON")}
TEXT = {"type": SignalType.TEXT}


def value(kind: dict, path: str, data: str) -> float | str | None:
    signal = Signal(name="S", source=SITE.devices["roof"].signals["wind"].source, **kind)
    return signal_value(signal, parse_json_path(path), parse_payload(data.encode()))


SITE = load_site("""
talaia: 1
site: test
name: Test
connections: {broker: {kind: mqtt, url: "mqtt://127.0.0.1"}}
devices:
  roof:
    name: Roof
    signals:
      wind: {name: Wind, unit: m/s, source: {topic: roof/weather, path: wind.speed}}
      rain: {name: Rain, type: state, states: ["no", "yes"], source: {topic: roof/rain}}
""")


@pytest.mark.parametrize(
    ("kind", "path", "data", "expected"),
    [
        (NUMBER, "a.b", '{"a": {"b": 2.5}}', 2.5),
        (NUMBER, "$.a['odd key'][1]", '{"a": {"odd key": [1, 7]}}', 7.0),
        (NUMBER, "SHT3X-44.Temperature", '{"SHT3X-44": {"Temperature": 21}}', 21.0),
        (NUMBER, "", " 21.5\n", 21.5),
        (NUMBER, "", '"21.5"', 21.5),
        (NUMBER, "a", '{"a": true}', 1.0),
        (NUMBER, "a", '{"a": null}', None),
        (STATE, "", "ON", 1.0),
        (STATE, "a", '{"a": "OFF"}', 0.0),
        (STATE, "a", '{"a": true}', 1.0),
        (STATE, "a", '{"a": 1}', 1.0),
        ({**STATE, "states": ("false", "true")}, "a", '{"a": true}', 1.0),
        (TEXT, "", "1.50", "1.50"),
        (TEXT, "", '{"a": 1}', '{"a": 1}'),
        (TEXT, "", '"in quotes"', "in quotes"),
        (TEXT, "a", '{"a": 7}', "7"),
    ],
)
def test_value_is_read_as_the_signal_has_it(
    kind: dict, path: str, data: str, expected: float | str | None
) -> None:
    assert value(kind, path, data) == expected


@pytest.mark.parametrize(
    ("kind", "path", "data", "said"),
    [
        (NUMBER, "a", '{"a": NaN}', "it is not JSON"),
        (NUMBER, "a", '{"a": "nan"}', "expected a number, found 'nan'"),
        (NUMBER, "", "Infinity", "expected a number"),
        (NUMBER, "a", '{"a": "warm"}', "expected a number, found 'warm'"),
        (NUMBER, "a", f'{{"a": {"9" * 400}}}', "expected a number"),
        (NUMBER, "a.b", '{"a": 1}', "'$.a.b': is not in"),
        (NUMBER, "a[3]", '{"a": [1]}', "'$.a[3]': is not in"),
        (NUMBER, "a", '{"a": {"b": 1}}', "is an object; say which field"),
        (NUMBER, "", "[1, 2]", "is a list; say which field"),
        (NUMBER, "a", "<html><body>Login</body></html>", "it is not JSON: '<html>"),
        (STATE, "", "on", "'on' is none of its states"),
        (STATE, "a", '{"a": 2}', "'2' is none of its states"),
        (STATE, "a", '{"a": 0.5}', "is none of its states"),
        ({**STATE, "states": ("a", "b", "c")}, "a", '{"a": true}', "none of its states"),
        (NUMBER, "a", "[" * 100_000, "it is not JSON"),
    ],
)
def test_what_is_no_value_is_told_and_never_guessed(
    kind: dict, path: str, data: str, said: str
) -> None:
    with pytest.raises(FieldError) as raised:
        value(kind, path, data)
    assert said in str(raised.value)


def test_bytes_that_are_no_text_are_told_for_each_signal_once() -> None:
    told: list[tuple[str, str]] = []
    (scope,) = scopes_of(SITE)
    signals = JsonSignals(
        scope,
        lambda signal: (signal.source.topic, signal.source.path),
        lambda address, problem: told.append((address, problem)),
    )
    for _ in range(2):
        assert not signals.read_payload("roof/weather", b"\xff\xfe", 0, 0)
    assert told == [("roof/wind", "roof/weather: it is not UTF-8 text")]
    assert signals.read_payload("roof/weather", b'{"wind": {"speed": 3}}', 5, 0)
    columns = signals.take_columns()
    assert columns is not None
    assert columns.value.tolist() == [3.0]
    assert not signals.read_payload("not/ours", b"1", 0, 0)


def assert_said(said: str) -> None:
    assert said.startswith("write it as")


@given(st.text())
def test_a_path_is_steps_or_an_error_that_says_how_it_is_written(path: str) -> None:
    try:
        steps = parse_json_path(path)
    except DescriptionError as error:
        said = error.remedy
        assert_said(said)
    else:
        assert all(step != "" for step in steps)


# Half of a surrogate pair is no text, and no JSON of ours has it.
characters = st.characters(exclude_characters="'\"[]\n", exclude_categories=["Cs"])
keys = st.text(characters, min_size=1, max_size=20)


@given(st.lists(st.one_of(keys, st.integers(0, 5)), min_size=1, max_size=6), st.floats(-1e9, 1e9))
def test_any_quoted_path_finds_what_lies_there(steps: list[str | int], number: float) -> None:
    made: object = number
    for step in reversed(steps):
        made = {step: made} if isinstance(step, str) else [*[None] * step, made]
    path = "$" + "".join(f"['{s}']" if isinstance(s, str) else f"[{s}]" for s in steps)
    assert value(NUMBER, path, json.dumps(made)) == number


@given(st.binary())
def test_no_bytes_bring_anything_but_a_value_or_an_error(data: bytes) -> None:
    signal = SITE.devices["roof"].signals["rain"]
    try:
        found = signal_value(signal, (), parse_payload(data))
    except FieldError:
        return
    assert found in (None, 0.0, 1.0)


def problems(connection: str, source: str, kind: str = "mqtt") -> list[str]:
    text = f"""
talaia: 1
site: test
name: Test
connections: {{there: {{kind: {kind}, {connection}}}}}
devices:
  roof:
    name: Roof
    signals:
      wind: {{name: Wind, unit: m/s, source: {{{source}}}}}
"""
    return [str(finding) for finding in check_site(load_site(text))]


BROKER, TOPIC = "url: 'mqtt://broker'", "topic: roof/weather"
SERVER, GET = "url: 'http://station.local'", "get: /api/weather"


@pytest.mark.parametrize(
    ("connection", "source", "kind", "said"),
    [
        (BROKER, TOPIC, "mqtt", ""),
        (BROKER, f"{TOPIC}, path: '$.a[0].b'", "mqtt", ""),
        (SERVER, f"{GET}, path: a", "http", ""),
        ("url: 'http://127.0.0.1:8080', here: true", GET, "http", ""),
        ("url: 'tcp://broker'", TOPIC, "mqtt", "expected mqtt or mqtts://host:port"),
        ("url: 'mqtt://me:secret@broker'", TOPIC, "mqtt", "there is a password in it"),
        (f"{BROKER}, password_file: p", TOPIC, "mqtt", "whose password is it?"),
        (f"{BROKER}, ca: x.pem", TOPIC, "mqtt", "only mqtts:// has certificates"),
        (f"{BROKER}, version: 4", TOPIC, "mqtt", "expected 3 or 5, found 4"),
        (BROKER, "topic: roof/+", "mqtt", "is a pattern, and a signal is one topic"),
        (BROKER, "path: a", "mqtt", "which topic is it?"),
        (BROKER, f"{TOPIC}, path: 'a..b'", "mqtt", "'a..b' is not a path into JSON"),
        (BROKER, GET, "mqtt", "knows no get"),
        (SERVER, "path: a", "http", "which address of the server is meant?"),
        (SERVER, "get: 'http://elsewhere/'", "http", "is not what can be asked for"),
        (SERVER, "get: //elsewhere/a", "http", "is not what can be asked for"),
        (SERVER, 'get: "/a\\r\\nX: y"', "http", "is not what can be asked for"),
        ("url: 'http://a/?key=b'", GET, "http", "it is not the root of a server"),
        ("url: 'http://169.254.169.254'", GET, "http", "where clouds keep their metadata"),
        ("url: 'http://localhost:1', poll: 0", GET, "http", "expected 0.1 to 86400 s, found 0"),
        ("url: 'http://127.0.0.1'", GET, "http", "which is this computer itself"),
        (f"{SERVER}, user: me", GET, "http", "user and password_file go together"),
        (f"{SERVER}, token_file: a, token_env: B", GET, "http", "token_file is given, too"),
    ],
)
def test_description_of_brokers_and_servers_is_checked(
    connection: str, source: str, kind: str, said: str
) -> None:
    found = problems(connection, source, kind)
    assert len(found) == (1 if said else 0), found
    assert not said or said in found[0]
