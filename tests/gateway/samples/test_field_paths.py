"""Fields: paths compiled once, values as the description wants them."""

import math
from types import SimpleNamespace as Message

import numpy as np
import pytest
from hypothesis import given, strategies as st

from talaia.gateway.errors import FieldError
from talaia.gateway.samples.field_paths import (
    compile_getter,
    number_of,
    parse_path,
    reader_of,
    text_of,
    yaw_of,
)
from talaia.model.connection import RosSource
from talaia.model.site import PositionFrame, Signal, SignalType

pytestmark = pytest.mark.pure


def signal(field: str = "data", **more: object) -> Signal:
    return Signal(name="S", source=RosSource(topic="/t", type="p/msg/T", field=field), **more)


def test_path_of_names_and_indexes_is_followed() -> None:
    message = Message(pose=Message(covariance=np.array([1.0, 2.0])), a=[[5, 6]])
    assert compile_getter("pose.covariance[1]")(message) == 2.0
    assert compile_getter("a[0][1]")(message) == 6


@pytest.mark.parametrize("path", ["", ".", "a.", ".a", "a..b", "[0]", "a[", "a[-1]", "a[x]", "a b"])
def test_what_is_no_path_is_refused(path: str) -> None:
    with pytest.raises(FieldError):
        parse_path(path)


@given(st.text(max_size=30))
def test_parser_allows_only_its_own_error(text: str) -> None:
    try:
        steps = parse_path(text)
    except FieldError:
        return
    again = "".join(f"[{each}]" if isinstance(each, int) else f".{each}" for each in steps)
    assert parse_path(again[1:]) == steps


def test_missing_field_names_the_path() -> None:
    with pytest.raises(FieldError, match=r"pose\.z"):
        compile_getter("pose.z")(Message(pose=Message(x=1)))
    with pytest.raises(FieldError, match=r"a\[3\]"):
        compile_getter("a[3]")(Message(a=[1]))


def test_truths_states_and_texts_become_numbers() -> None:
    assert reader_of(signal())(Message(data=True)) == (1.0,)
    state = signal(type=SignalType.STATE, states=("closed", "open"))
    assert reader_of(state)(Message(data="open")) == (1.0,)
    assert number_of("1.5") == 1.5
    assert reader_of(signal(scale=100.0))(Message(data=0.5)) == (50.0,)


def test_list_without_index_says_what_to_write() -> None:
    with pytest.raises(FieldError, match=r"ranges\[0\]"):
        reader_of(signal("ranges"))(Message(ranges=np.zeros(3)))
    with pytest.raises(FieldError):
        number_of(Message())


def test_local_position_has_x_y_and_yaw() -> None:
    quaternion = Message(x=0.0, y=0.0, z=math.sin(0.5), w=math.cos(0.5))
    message = Message(pose=Message(position=Message(x=1.0, y=2.0), orientation=quaternion))
    read = reader_of(signal("pose.position", type=SignalType.POSITION, yaw_from="pose.orientation"))
    assert read(message) == pytest.approx((1.0, 2.0, 1.0))


def test_local_position_without_orientation_has_no_yaw() -> None:
    x, y, yaw = reader_of(signal("", type=SignalType.POSITION))(Message(x=1.0, y=2.0))
    assert (x, y) == (1.0, 2.0)
    assert math.isnan(yaw)


def test_geographic_position_is_read_from_a_fix() -> None:
    read = reader_of(signal("", type=SignalType.POSITION, frame=PositionFrame.WGS84))
    assert read(Message(latitude=41.4, longitude=2.2, altitude=12.0)) == (41.4, 2.2, 12.0)


@given(st.floats(-math.pi, math.pi))
def test_yaw_comes_back_from_its_quaternion(yaw: float) -> None:
    back = yaw_of(0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
    assert math.isclose(math.cos(back), math.cos(yaw), abs_tol=1e-9)
    assert math.isclose(math.sin(back), math.sin(yaw), abs_tol=1e-9)


@given(st.text(alphabet=st.characters(), max_size=3000))
def test_any_text_fits_the_wire(text: str) -> None:
    assert len(text_of(text).encode()) >= 0
    assert len(text_of(text)) <= 2000
