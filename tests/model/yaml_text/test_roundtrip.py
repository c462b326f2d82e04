"""Any description that ``check`` accepts survives load → save → load, whatever part of it is used.

Real descriptions that use all there is are changed at random places, by the types of the model
itself: what is added to the model later is changed here, too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import msgspec
import pytest
from hypothesis import HealthCheck, assume, given, settings, strategies as st
from many_examples import examples
from msgspec import inspect

from talaia.model.checks.site_checks import check_site
from talaia.model.site import Site
from talaia.model.yaml_text.load import dump_site, load_site
from talaia.model.yaml_text.save import save_into_text
from talaia.model.yaml_text.write import write_description

from ..test_detection import MODEL, TEXT as SEEING
from .test_load import GUARDED, SEVERAL

EXAMPLES = sorted((Path(__file__).parents[3] / "examples").glob("*/site.yaml"))
RECORDED = """\
talaia: 1
site: recorded
name: Recorded   # while it moves
ros2: {}
devices: {base: {name: Base}}
recording: {topics: [/odom], before: 5}
"""
TEXTS = [*(path.read_text() for path in EXAMPLES), GUARDED, SEVERAL, RECORDED, SEEING + MODEL]
BASES = [(text, load_site(text)) for text in TEXTS]
Way = tuple[str | int, ...]

words = st.from_regex(r"[a-z][a-z0-9_]{0,8}", fullmatch=True)
numbers = st.sampled_from([0.0, 0.1, 0.25, 1.0, 5.0, 10.0, 60.0]) | st.floats(
    allow_nan=False, allow_infinity=False
)
texts = (
    st.text(max_size=12)
    | words
    | st.sampled_from(["yes", "1.0", "~", " a", "a: b", "# a", "2001-01-01", "°C", "/a/b", "m/s"])
)


def places(value: object, at: Way = ()) -> Iterator[tuple[Way, object]]:
    """Every struct and mapping in a description, with the way to it."""
    if isinstance(value, msgspec.Struct):
        yield at, value
        for name in value.__struct_fields__:
            yield from places(getattr(value, name), (*at, name))
    elif isinstance(value, dict):
        yield at, value
        for key, each in value.items():
            yield from places(each, (*at, key))
    elif isinstance(value, tuple):
        for index, each in enumerate(value):
            yield from places(each, (*at, index))


def with_value(value: object, at: Way, new: object) -> object:
    """Give a copy in which something else stands at a place."""
    if not at:
        return new
    step, rest = at[0], at[1:]
    if isinstance(value, msgspec.Struct):
        inner = with_value(getattr(value, str(step)), rest, new)
        return msgspec.structs.replace(value, **{str(step): inner})
    if isinstance(value, dict):
        return {
            key: with_value(each, rest, new) if key == step else each for key, each in value.items()
        }
    assert isinstance(value, tuple)
    return tuple(
        with_value(each, rest, new) if index == step else each for index, each in enumerate(value)
    )


def known(kind: type) -> list[object]:
    """The structs of a kind that stand in the descriptions."""
    return [one for _, site in BASES for _, one in places(site) if type(one) is kind]


def of_type(shape: object) -> st.SearchStrategy[object]:
    """Values of a type of the model; a struct is one that somebody has written."""
    match shape:
        case inspect.BoolType():
            return st.booleans()
        case inspect.IntType():
            return st.integers(-2, 10_000)
        case inspect.FloatType():
            return numbers
        case inspect.StrType():
            return texts
        case inspect.NoneType():
            return st.none()
        case inspect.EnumType():
            return st.sampled_from(list(shape.cls))
        case inspect.UnionType():
            return st.one_of([of_type(each) for each in shape.types])
        case inspect.VarTupleType():
            return st.lists(of_type(shape.item_type), max_size=3).map(tuple)
        case inspect.TupleType():
            return st.tuples(*(of_type(each) for each in shape.item_types))
        case inspect.DictType():
            return st.dictionaries(words, of_type(shape.value_type), max_size=2)
        case inspect.StructType():
            there = known(shape.cls)
            return st.sampled_from(there) if there else made(shape)
        case _:
            raise AssertionError(f"a type that is not made here: {shape}")


def made(shape: inspect.StructType) -> st.SearchStrategy[object]:
    """Structs of a kind that nobody has written yet."""
    return st.builds(
        shape.cls, **{each.name: of_type(each.type) for each in shape.fields if each.required}
    )


@st.composite
def changed(draw: st.DrawFn) -> tuple[str, Site, Site]:
    """A description's text, what it says, and what it shall say instead."""
    text, site = draw(st.sampled_from(BASES))
    new: object = site
    for _ in range(draw(st.integers(1, 3))):
        at, found = draw(st.sampled_from(list(places(new))))
        if isinstance(found, dict):
            new = with_value(new, at, draw(turned(found)))
            continue
        assert isinstance(found, msgspec.Struct)
        shape = inspect.type_info(type(found))
        assert isinstance(shape, inspect.StructType)
        # Keys that are another protocol's are refused by `check`, and nobody means them.
        field = draw(st.sampled_from([each for each in shape.fields if each.name != "foreign"]))
        new = with_value(new, (*at, field.name), draw(of_type(field.type)))
    assert isinstance(new, Site)
    return text, site, new


@st.composite
def turned(draw: st.DrawFn, mapping: dict[str, object]) -> dict[str, object]:
    """The same mapping in another order, without some, or with one twice under two names."""
    keys = draw(st.permutations(list(mapping)))
    kept = {key: mapping[key] for key in keys[: draw(st.integers(0, len(keys)))] or keys}
    if kept and draw(st.booleans()):
        kept[draw(words)] = next(iter(kept.values()))
    return kept


def order(value: object) -> object:
    if isinstance(value, msgspec.Struct):
        return [order(getattr(value, each)) for each in value.__struct_fields__]
    if isinstance(value, dict):
        return [(key, order(each)) for key, each in value.items()]
    return None


@settings(
    deadline=None, max_examples=examples(20, many=1000),
    suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow],
)  # fmt: skip
@given(changed(), st.sampled_from([write_description, dump_site]))
def test_any_description_that_check_accepts_survives_load_save_load(
    change: tuple[str, Site, Site], write: Callable[[Site], str]
) -> None:
    text, _, after = change
    assume(not check_site(after))
    assert load_site(write(after)) == after
    read = load_site(save_into_text(text, after))
    assert read == after
    assert order(read) == order(after)
    assert save_into_text(save_into_text(text, after), after) == save_into_text(text, after)


@pytest.mark.parametrize(("text", "site"), BASES, ids=range(len(BASES)))
def test_the_descriptions_they_are_made_of_are_right(text: str, site: Site) -> None:
    assert check_site(site) == []
    assert save_into_text(text, site) == text
