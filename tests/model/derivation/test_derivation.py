"""Signals over signals: what `check` says of them, in which order they are worked out, in what."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given, strategies as st

from talaia.model.checks.site_checks import check_site
from talaia.model.connection import DerivedSource
from talaia.model.derivation.plan import derived_addresses, find_cycle, plan_derivations
from talaia.model.units.quantity import PLAIN, QuantityMismatch, quantity_of_unit
from talaia.model.units.unit import UNITS
from talaia.model.yaml_text.load import dump_site, load_site

pytestmark = pytest.mark.pure

SITE = """
talaia: 1
site: test
name: Test
connections: {shell: {kind: process}}
devices:
  w:
    name: Weather
    signals:
      outside: {name: Outside, unit: "°C", source: {run: outside}}
      dew: {name: Dew point, unit: "°C", source: {run: dew}}
      wind: {name: Wind, unit: km/h, source: {run: wind}}
      gust: {name: Gust, unit: m/s, source: {run: gust}}
      plain: {name: Plain, source: {run: plain}}
      volts: {name: Voltage, unit: V, source: {run: volts}}
      amps: {name: Current, unit: A, source: {run: amps}}
      roof: {name: Roof, type: state, states: [shut, open], source: {run: roof}}
      word: {name: Word, type: text, source: {run: word}}
"""


def problems(lines: str, more: str = "") -> list[str]:
    text = SITE + "".join(f"      {line}\n" for line in lines.strip().splitlines()) + more
    return [str(finding) for finding in check_site(load_site(text))]


def signal(expression: str, rest: str = "") -> str:
    return f"x: {{name: X, source: {{expression: '{expression}'}}{rest}}}"


@pytest.mark.parametrize(
    ("expression", "rest"),
    [
        ("{w/outside} - {w/dew}", ", unit: °C"),
        ("{w/outside} - {w/dew}", ", unit: K"),
        ("({w/outside} + {w/dew}) / 2", ", unit: °C"),
        ("{w/outside} + 273.15", ", unit: K"),
        ("{w/wind} / 3.6", ", unit: m/s"),
        ("max({w/wind} / 3.6, {w/gust})", ", unit: m/s"),
        ("{w/volts} * {w/amps}", ", unit: W"),
        ("{w/volts} * {w/amps}", ", unit: VA"),
        ("{w/plain} * 0.01", ", unit: hPa"),
        ("abs({w/wind}) / {w/wind}", ""),
        ("{w/gust} / {w/gust} * 100", ", unit: '%'"),
        # There is no unit for it in the table.
        ("{w/gust} * {w/gust}", ""),
        (
            '{w/roof} == "open" and {w/gust} > 10 or {w/word} == "x"',
            ", type: state, states: [calm, storm]",
        ),
    ],
)
def test_expression_whose_unit_agrees_is_accepted(expression: str, rest: str) -> None:
    assert problems(signal(expression, rest)) == []


@pytest.mark.parametrize(
    ("expression", "rest", "said"),
    [
        ("{w/wind} - {w/gust}", ", unit: m/s", "at letter 10: km/h and m/s are two units of the"),
        ("{w/outside} + {w/gust}", ", unit: m/s", "°C and m/s cannot be added"),
        ("{w/wind}", ", unit: m/s", "expected m/s, and the expression gives km/h"),
        ("{w/outside}", ", unit: K", "expected K, and the expression gives °C"),
        ("{w/volts} * {w/amps}", ", unit: V", "expected V, and the expression gives W"),
        ("{w/gust} * 2", "", "expected no unit, and the expression gives m/s or its like"),
        ("{w/wind} > {w/gust}", ", type: state, states: [a, b]", "two units of the same kind"),
        ("{w/gust} > 3", "", "its expression gives a yes or no; write: type: state"),
        ("{w/gust}", ", type: state, states: [a, b]", "gives a number; write: type: number"),
        ("{w/gust} > 3", ", type: state, states: [a, b, c]", "a condition has two states, found 3"),
        ("{w/word}", ", type: text", "it gives a text"),
        ("1 + 2", "", "there is no signal in it"),
        ("{w/nowhere} + 1", "", "at letter 1: there is no signal 'w/nowhere'"),
        ("{w/plain} +", "", "at letter 12: it ends too soon"),
        ("{w/plain}", ", scale: 2", "what is worked out has no scale"),
        ("{w/plain}", ", frozen_after: 60", "a sensor can freeze, a calculation cannot"),
        ("{w/plain}", ", visibility: public", "guests would see w/plain in it"),
        ("{w/plain} + {w/x}", "", "it is worked out from itself: w/x ← w/x"),
    ],
)
def test_what_does_not_fit_is_told_with_its_place(expression: str, rest: str, said: str) -> None:
    found = problems(signal(expression, rest))
    assert len(found) == 1
    assert found[0].startswith("$.devices.w.signals.x.")
    assert said in found[0]


def test_circle_of_signals_is_told_once_and_by_name() -> None:
    lines = "\n".join(
        f"{name}: {{name: N, source: {{expression: '{{w/{other}}} + 1'}}}}"
        for name, other in (("a", "b"), ("b", "c"), ("c", "a"), ("d", "a"))
    )
    (found,) = problems(lines)
    assert "$.devices.w.signals.a.source.expression" in found
    assert "w/a ← w/b ← w/c ← w/a" in found
    assert (
        plan_derivations(load_site(SITE + "".join(f"      {x}\n" for x in lines.split("\n")))) == []
    )


def test_another_sources_key_beside_an_expression_is_told() -> None:
    (found,) = problems("x: {name: X, source: {expression: '{w/plain}', run: date}}")
    assert found.startswith("$.devices.w.signals.x.source.run: what is worked out from other")


def test_safety_goes_by_no_signal_that_is_worked_out() -> None:
    more = """
interlocks:
  close: {name: C, when: [{signal: w/x, above: 3, max_age: 5}], refuse: ["w/*"]}
"""
    (found,) = problems(signal("{w/plain} * 2"), more)
    assert found.startswith("$.devices.w.signals.x: an interlock, enclosure, STOP, driving or")


def test_device_of_nothing_but_derived_signals_needs_no_connection() -> None:
    text = SITE.replace("{kind: process}}", "{kind: process}, other: {kind: process}}")
    text = text.replace("name: Weather", "name: Weather\n    connection: shell")
    text += "  sums:\n    name: Sums\n    signals:\n      " + signal("{w/plain}")
    site = load_site(text)
    assert check_site(site) == []
    assert derived_addresses(site) == {"sums/x"}


def test_description_comes_back_as_it_was_written() -> None:
    site = load_site(SITE + "      " + signal("{w/outside} - {w/dew}", ", unit: °C"))
    assert site.devices["w"].signals["x"].source == DerivedSource(
        expression="{w/outside} - {w/dew}"
    )
    assert load_site(dump_site(site)) == site


def needs_of(edges: list[tuple[int, int]], many: int) -> dict[str, tuple[str, ...]]:
    return {
        f"w/s{number}": tuple(f"w/s{two}" for one, two in edges if one == number)
        for number in range(many)
    }


MANY = 8
edge_lists = st.lists(
    st.tuples(st.integers(0, MANY - 1), st.integers(0, MANY - 1)), unique=True, max_size=20
)


@given(edge_lists)
def test_all_outside_of_circles_stand_behind_what_they_need(edges: list[tuple[int, int]]) -> None:
    needs = needs_of(edges, MANY)
    lines = [
        f"      s{name[3:]}: {{name: N, source: {{expression: "
        f"'{' + '.join('{' + other + '}' for other in (*others, 'w/plain'))}'}}}}\n"
        for name, others in needs.items()
    ]
    order = [derived.address for derived in plan_derivations(load_site(SITE + "".join(lines)))]
    for place, address in enumerate(order):
        assert set(needs[address]) <= set(order[:place])
    # Whoever is left out goes in circles, or needs one that does.
    for address in needs.keys() - set(order):
        assert find_cycle(needs, address) or set(needs[address]) - set(order)


@given(edge_lists)
def test_way_of_a_circle_follows_what_is_needed_and_comes_back(
    edges: list[tuple[int, int]],
) -> None:
    needs = needs_of(edges, MANY)
    for address in needs:
        way = find_cycle(needs, address)
        if way:
            assert way[0] == way[-1] == address
            assert all(two in needs[one] for one, two in pairwise(way))


@given(st.sampled_from(sorted(UNITS)), st.sampled_from(sorted(UNITS)))
def test_units_add_in_either_order_or_in_none(one: str, other: str) -> None:
    left, right = quantity_of_unit(one), quantity_of_unit(other)
    try:
        found = left.plus(right)
    except QuantityMismatch:
        with pytest.raises(QuantityMismatch):
            right.plus(left)
        return
    assert found == right.plus(left)
    assert left.times(PLAIN).powers == left.powers
    assert left.fits_unit(one)
