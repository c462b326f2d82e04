"""YAML as descriptions use it is read as PyYAML itself reads it; the rest is refused."""

from __future__ import annotations

import pytest
import yaml
from hypothesis import given, settings, strategies as st

from talaia.model.yaml_text.document import document_of, quoting_powers_of_ten

whole = st.integers(-(2**63), 2**64 - 1)
plain = st.none() | st.booleans() | whole | st.floats(allow_nan=False) | st.text(max_size=20)
values = st.recursive(
    plain,
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(
            st.text(max_size=8) | whole | st.booleans(),
            inner,
            max_size=4,
        )
    ),
    max_leaves=20,
)
WORDS = ["yes", "No", "~", "0x1f", ".inf", "=",
         "-", "on:", "'a'", '"\\u00e9"', "!!str 5", "!!float 5", "|\n  a\n  b", ">-\n  a\n  b",
         "[a, {b: c}]", "{a: [1, 2.5]}", "a # b", "'#'", "", "!  x", "? a\n: b"]  # fmt: skip


@quoting_powers_of_ten
class Writer(yaml.SafeDumper):
    """PyYAML's own, but that a text such as 1e9, which it takes for one, stands in quotes."""


@settings(deadline=None)
@given(value=values, flow=st.booleans())
def test_whatever_is_dumped_is_read_as_pyyaml_reads_it(value: object, *, flow: bool) -> None:
    text = yaml.dump(value, Dumper=Writer, default_flow_style=flow, allow_unicode=True)
    read = document_of(text)
    assert read == yaml.safe_load(text)
    assert repr(read) == repr(yaml.safe_load(text))


@pytest.mark.parametrize("word", WORDS)
def test_every_spelling_of_a_value_is_read_as_pyyaml_reads_it(word: str) -> None:
    try:
        expected = yaml.safe_load(word)
    except yaml.YAMLError:
        with pytest.raises(yaml.YAMLError):
            document_of(word)
        return
    assert repr(document_of(word)) == repr(expected)


def test_an_alias_is_what_its_anchor_is() -> None:
    assert document_of("a: &x {b: 1}\nc: *x\nd: &y 5\ne: [*y, *x]") == {
        "a": {"b": 1}, "c": {"b": 1}, "d": 5, "e": [5, {"b": 1}],
    }  # fmt: skip


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a: *b", "there is no &b"),
        ("a: &a [*a]", "within what &a means"),
        ("a: 1\na: 2", "written twice"),
        ("{a: 1, <<: {b: 2}}", "merge keys"),
        ("? [a]\n: b", "where a name belongs"),
        ("a: 1\n---\nb: 2", "second description"),
        ("a: !own b", "no meaning"),
        ("a: !!set {b}", "no meaning"),
        ("a: !!seq {b: c}", "no meaning"),
        ("a: !!float fast", "is not of"),
        ("a: !!int ''", "is not of"),
        ("a: !!bool 7", "is not of"),
        ("a: !!timestamp 2001-01-01", "no meaning"),
        ("a: !!binary aGVsbG8=", "no meaning"),
        ("[" * 100, "nested deeper"),
        ("talaia: 0x" + "f" * 5_000, "64 bits"),
        ("a: [1, 0x" + "f" * 5_000 + "]", "64 bits"),
        ("? 0x" + "f" * 5_000 + "\n: a", "64 bits"),
        ("a: 18446744073709551616", "64 bits"),
        ("a: -9223372036854775809", "64 bits"),
        ("a: !!int 0b" + "1" * 65, "64 bits"),
    ],
)
def test_what_no_description_needs_is_refused_with_its_place(text: str, said: str) -> None:
    with pytest.raises(yaml.MarkedYAMLError, match=said) as caught:
        document_of(text)
    assert caught.value.problem_mark is not None


def test_aliases_of_aliases_do_not_grow_without_bound() -> None:
    rows = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    for level in range(1, 9):
        inner = ", ".join([f"*a{level - 1}"] * 10)
        rows.append(f"a{level}: &a{level} [{inner}]")
    with pytest.raises(yaml.MarkedYAMLError, match="too large"):
        document_of("\n".join(rows))


@pytest.mark.parametrize(
    ("text", "read"),
    [
        ("1_000", "1_000"),
        ("0b11", "0b11"),
        ("2001-01-01", "2001-01-01"),
        ("1e400", "1e400"),
        ("1e3", 1000.0),
        ("-2.5E-3", -0.0025),
        ("1:30", "1:30"),
        ("12:30:00", "12:30:00"),
        ("12:30.5", "12:30.5"),
        ("010", "010"),
        ("-007", "-007"),
        ("0", 0),
        ("0.5", 0.5),
        ("0x10", 16),
        # To the base of 60 it would be quadratic in its digits: half a minute of them in one text.
        ("1" + ":1" * 100_000, "1" + ":1" * 100_000),
    ],
)
def test_numbers_are_those_of_yaml_1_2_and_what_is_read_in_two_ways_is_a_text(
    text: str, read: object
) -> None:
    found = document_of(f"a: {text}")
    assert found == {"a": read}
    assert type(found["a"]) is type(read)
