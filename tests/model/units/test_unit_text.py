"""Units as people write them: what they measure, and in what else they can be shown."""

import pytest
from hypothesis import given, strategies as st

from talaia.model.units.conversion import (
    conversion_between,
    likely_unit,
    shown_units,
    units_like,
)
from talaia.model.units.unit import UNITS, unit_of
from talaia.model.units.unit_measures import COUNTED, MEASURES, OTHER_NAMES
from talaia.model.units.unit_text import LONGEST_UNIT, measure_of

# What pint calls a unit of the table where it knows the symbol as something else, or not at all.
PINT_NAMES = {"%": "percent", "kn": "knot", "°C": "degC", "°F": "degF", "inHg": "inch_Hg"}
# Levels and what is counted: pint has no even scale for them, or no name.
OWN = {"mag/arcsec²", "dBm", "dB", "ADU", "px", "counts", "‰", "ppb"}


@pytest.mark.parametrize("symbol", sorted(MEASURES.keys() - OWN))
def test_the_table_says_what_pint_says(symbol: str) -> None:
    from talaia.model.units.pint_names import _registry, measure_by_pint

    name = PINT_NAMES.get(symbol, symbol)
    found = measure_by_pint(name) if name.isalpha() or name.startswith("°") else None
    if found is not None:
        assert found.powers == MEASURES[symbol].powers
        assert found.factor == pytest.approx(MEASURES[symbol].factor, rel=1e-6)
        assert found.zero == pytest.approx(MEASURES[symbol].zero, rel=1e-9)
        return
    # A product: pint reads these few, which we wrote ourselves, as an expression.
    written = _registry().Quantity(1.0, name).to_base_units()
    assert written.magnitude == pytest.approx(MEASURES[symbol].factor, rel=1e-6)


@pytest.mark.parametrize(
    ("text", "like", "factor"),
    [
        ("µg/m³", "kg/m³", 1e-9),
        ("ug/m^3", "kg/m³", 1e-9),
        ("L/min", "m³/s", 1 / 60_000),
        ("kW·h", "J", 3.6e6),
        ("kW*h", "Wh", 1000.0),
        ("miles per hour", "mph", 1.0),
        ("m/s/s", "m/s²", 1.0),
        ("1/min", "Hz", 1 / 60),
        ("W/(m²·K)", "W/m²/K", 1.0),
        ("MiB/s", "B/s", 2.0**20),
        ("mmol/L", "mol/m³", 1.0),
        ("°F/h", "K/h", 5 / 9),
        ("GHz", "Hz", 1e9),
        ("%RH", "%", 1.0),
        ("counts/s", "counts/min", 60.0),
        ("gal/h", "L/h", 3.785411784),
        ("GPM", "L/min", 3.785411784),
        ("cfm", "m³/h", 1.69901082),
        ("sccm", "L/min", 1e-3),
        ("fpm", "m/s", 5.08e-3),
        ("bpm", "Hz", 1 / 60),
        ("/min", "1/min", 1.0),
        ("r/min", "rpm", 1.0),
        ("m.s-1", "m/s", 1.0),
        ("kgf", "N", 9.80665),
        ("gₙ", "m/s²", 9.80665),
        ("lbf·ft", "N·m", 1.3558179483),
        ("kgf·cm", "Nm", 0.0980665),
        ("inH2O", "Pa", 249.08891),
        ("Mbps", "Mbit/s", 1.0),
        ("mPa·s", "Pa·s", 1e-3),
        ("kV/m", "V/m", 1e3),
        ("e-/ADU", "electrons/ADU", 1.0),
        ("e⁻/s", "electrons/s", 1.0),
        ("amps", "mA", 1e3),
        ("kvar", "var", 1e3),
        ("cm³", "m³", 1e-6),
    ],
)
def test_a_unit_is_read_as_people_write_it(text: str, like: str, factor: float) -> None:
    way = conversion_between(text, like)
    assert way is not None
    assert way.factor == pytest.approx(factor)
    assert way.offset == 0


@pytest.mark.parametrize(
    "text",
    [
        "m/z",
        "foo",
        "9**9**9",
        "m**99",
        "m^99",
        "//",
        "m·",
        "·m",
        "deg X",
        "(m",
        "m/(s",
        "1",
        # Not a power that anything has, nor what letters happen to be read as: atto, ronna, peta.
        *("m0", "units", "pts", "Rh", "EU", "VAh", "°dH"),
        "",
        "\n",
    ],
)
def test_what_nobody_knows_measures_nothing(text: str) -> None:
    assert measure_of(text) is None
    assert units_like(text) == []
    assert unit_of(text).symbol == text


@given(st.text(max_size=2 * LONGEST_UNIT))
def test_no_text_of_a_unit_raises(text: str) -> None:
    measure_of(text)
    likely_unit(text)


@given(st.sampled_from(sorted(MEASURES)), st.sampled_from(sorted(MEASURES)), st.floats(-1e6, 1e6))
def test_a_value_that_is_shown_in_another_unit_comes_back(
    one: str, other: str, value: float
) -> None:
    there, back = conversion_between(one, other), conversion_between(other, one)
    assert (there is None) == (back is None)
    if there is not None and back is not None:
        scale = max(abs(value), abs(there.offset / there.factor))
        assert back.convert(there.convert(value)) == pytest.approx(
            value, rel=1e-9, abs=scale * 1e-9
        )


@pytest.mark.parametrize(
    ("stored", "shown", "value", "said"),
    [
        ("°C", "°F", 20.0, 68.0),
        ("°F", "°C", -40.0, -40.0),
        ("K", "°C", 0.0, -273.15),
        ("m/s", "kn", 10.0, 19.4384),
        ("m/s", "mph", 10.0, 22.3694),
        ("hPa", "inHg", 1013.25, 29.9213),
        ("bar", "psi", 1.0, 14.5038),
        ("mbar", "kPa", 1000.0, 100.0),
        ("rad/s", "rpm", 1.0, 9.5493),
        ("mA", "A", 1500.0, 1.5),
        ("m³/h", "L/min", 6.0, 100.0),
        ("kWh", "J", 1.0, 3.6e6),
    ],
)
def test_values_are_shown_by_factor_and_offset(
    stored: str, shown: str, value: float, said: float
) -> None:
    way = conversion_between(stored, shown)
    assert way is not None
    assert way.convert(value) == pytest.approx(said, rel=1e-5)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        *(("rpm", "Hz"), ("°", "%"), ("rad/s", "Hz"), ("px", "counts"), ("px", "%")),
        *(("dBm", "W"), ("mag/arcsec²", "lx"), ("°C", "V"), ("m", "m²"), ("foo", "m")),
        # What SI alone would take for one.
        *(("N·m", "J"), ("lbf·ft", "kWh"), ("VA", "W"), ("var", "W"), ("fps", "m/s")),
        *(("fps", "Hz"), ("g", "m/s²"), ("mag", "mag/arcsec²"), ("lx", "W/m²")),
    ],
)
def test_what_measures_something_else_is_never_shown_so(one: str, other: str) -> None:
    assert conversion_between(one, other) is None


def test_a_change_is_shown_as_finely_as_it_is_stored() -> None:
    way = conversion_between("m/s", "km/h")
    assert way is not None
    assert (way.digits_for(2), way.digits_for(0)) == (1, 0)
    finer = conversion_between("hPa", "bar")
    assert finer is not None
    assert (finer.digits_for(1), finer.digits_for(9)) == (4, 9)


def test_the_first_choice_counts_and_what_cannot_be_converted_is_left_out() -> None:
    person, site = {"m/s": "kn", "V": "m", "°C": "°C"}, {"m/s": "km/h", "°C": "°F", "hPa": "bar"}
    assert {unit: way.unit for unit, way in shown_units(person, site).items()} == {
        "m/s": "kn",
        "hPa": "bar",
    }


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        *(("m/z", "m/s"), ("KPA", "kPa"), ("hz", "Hz"), ("Celcius", "°C"), ("metrs", "m")),
        *(("m/sec^^2", "m/s²"), ("Voltz", "V"), ("foo", ""), ("q", "")),
        # Alike in letters, and of another kind: charge, pressure, ozone.
        *(("VAh", ""), ("war", ""), ("DU", ""), ("a/s", ""), ("scm", "")),
    ],
)
def test_a_slip_of_a_unit_is_told_by_its_likeness(text: str, meant: str) -> None:
    assert likely_unit(text) == meant


@pytest.mark.parametrize("text", sorted(MEASURES.keys() | OTHER_NAMES.keys() | COUNTED))
def test_a_unit_that_is_known_is_no_slip_of_another(text: str) -> None:
    assert measure_of(text) is not None
    assert likely_unit(text) == ""


def test_every_unit_of_the_table_says_itself() -> None:
    assert all(unit_of(symbol).symbol == symbol for symbol in UNITS)
