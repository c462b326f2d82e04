"""Frames: what goes in comes out, and what is hostile is refused with a close code."""

from __future__ import annotations

import json
import math
import re
from contextlib import suppress
from pathlib import Path
from typing import get_args

import msgspec
import pytest
from hypothesis import given, strategies as st

from talaia.wire import browser, frames
from talaia.wire.errors import PeerError, UnknownKind
from talaia.wire.message import PROTOCOL, Codec, is_compatible

CODECS: list[Codec] = [
    frames.LINK_FROM_GATEWAY,
    frames.LINK_FROM_HUB,
    frames.MEDIA_FROM_GATEWAY,
    frames.MEDIA_FROM_HUB,
    browser.FROM_BROWSER,
    browser.TO_BROWSER,
    browser.MEDIA_TO_BROWSER,
    browser.MEDIA_FROM_BROWSER,
    frames.FILES_FROM_GATEWAY,
    frames.FILES_FROM_HUB,
    browser.TOPIC_TO_BROWSER,
    browser.TOPIC_FROM_BROWSER,
]
DRIVE = frames.DriveFrame(
    device="base", session="s", epoch=3, seq=9, tick=77, held_ms=4.5, linear=0.1, angular=-1.0
)


def test_a_frame_survives_both_forms() -> None:
    for codec, message in (
        (frames.LINK_FROM_HUB, DRIVE),
        (
            frames.LINK_FROM_GATEWAY,
            frames.SampleBatch(
                boot="b", first=7, catalogue="c", base_us=1, channel=b"\0\1", offset=b"\0" * 4,
                value=b"\0" * 8, texts={0: "on"},
            ),
        ),
        (browser.FROM_BROWSER, browser.Subscribe(sub=1, site="agv", channels=["base/speed"])),
    ):  # fmt: skip
        assert codec.decode(codec.encode(message)) == message
        assert codec.decode(codec.encode_text(message)) == message


def test_a_newer_peers_unknown_field_is_ignored_and_a_missing_one_takes_its_default() -> None:
    fields = msgspec.to_builtins(DRIVE) | {"from_the_future": [1, 2, 3]}
    del fields["held_ms"]
    message = frames.LINK_FROM_HUB.decode(msgspec.msgpack.encode(fields))
    assert message == msgspec.structs.replace(DRIVE, held_ms=0.0)


@pytest.mark.parametrize("codec", CODECS, ids=map(str, range(len(CODECS))))
@given(data=st.binary(max_size=400))
def test_any_bytes_are_a_frame_or_a_peer_error(codec: Codec, data: bytes) -> None:
    with suppress(PeerError):
        codec.decode(data)


@pytest.mark.parametrize("codec", CODECS, ids=map(str, range(len(CODECS))))
@given(text=st.text(max_size=200))
def test_any_text_is_a_frame_or_a_peer_error(codec: Codec, text: str) -> None:
    with suppress(PeerError):
        codec.decode(text)


def test_a_frame_over_the_limit_is_refused_before_it_is_read() -> None:
    with pytest.raises(PeerError) as caught:
        browser.MEDIA_FROM_BROWSER.decode(b"\0" * 5000)
    assert caught.value.code == 1009


def test_a_deeply_nested_frame_is_refused() -> None:
    with pytest.raises(PeerError):
        frames.LINK_FROM_HUB.decode(b"\x91" * 5000 + b"\xc0")


def test_a_negative_or_huge_sequence_is_refused() -> None:
    for seq in (-1, 2**63):
        fields = msgspec.to_builtins(DRIVE) | {"seq": seq}
        with pytest.raises(PeerError):
            frames.LINK_FROM_HUB.decode(msgspec.msgpack.encode(fields))


def test_a_driving_frame_cannot_come_from_the_gateway() -> None:
    with pytest.raises(PeerError, match="unknown kind"):
        frames.LINK_FROM_GATEWAY.decode(frames.LINK_FROM_HUB.encode(DRIVE))


def shapes() -> list[tuple[Codec, type[msgspec.Struct]]]:
    unions = [
        frames.FromGateway, frames.FromHub, frames.MediaFromGateway, frames.MediaFromHub,
        browser.FromBrowser, browser.ToBrowser, browser.MediaToBrowser, browser.MediaFromBrowser,
        frames.FilesFromGateway, frames.FilesFromHub,
        browser.TopicToBrowser, browser.TopicFromBrowser,
    ]  # fmt: skip
    return [
        (codec, shape)
        for codec, union in zip(CODECS, unions, strict=True)
        for shape in (get_args(union) or (union,))
    ]


def unlimited(kind: msgspec.inspect.Type, where: str) -> list[str]:
    inner: list[msgspec.inspect.Type] = []
    wrong = False
    match kind:
        case msgspec.inspect.StrType() if kind.pattern is not None:
            # Its end is given, and nothing in it repeats without one.
            wrong = not kind.pattern.endswith("$") or any(each in kind.pattern for each in "*+")
        case msgspec.inspect.StrType() | msgspec.inspect.BytesType():
            wrong = kind.max_length is None
        case msgspec.inspect.ListType():
            wrong, inner = kind.max_length is None, [kind.item_type]
        case msgspec.inspect.DictType():
            wrong, inner = kind.max_length is None, [kind.value_type]
        case msgspec.inspect.UnionType():
            # A command's argument: its limits are the description's.
            inner = [x for x in kind.types if not isinstance(x, msgspec.inspect.IntType)]
        case msgspec.inspect.IntType():
            wrong = kind.ge is None or (kind.le is None and kind.lt is None)
    return [where] * wrong + [each for one in inner for each in unlimited(one, where)]


def test_every_text_list_mapping_and_number_has_a_limit() -> None:
    found = []
    for _, shape in shapes():
        info = msgspec.inspect.type_info(shape)
        assert isinstance(info, msgspec.inspect.StructType)
        for field in info.fields:
            found += unlimited(field.type, f"{shape.__name__}.{field.name}")
    assert found == []


def example(kind: msgspec.inspect.Type) -> object:
    match kind:
        case msgspec.inspect.EnumType():
            return next(iter(kind.cls))
        case msgspec.inspect.StrType():
            counted = re.fullmatch(r"\^\[0-9a-f\]\{(\d+)\}\$", kind.pattern or "")
            return "a" * int(counted[1]) if counted else "text"
        case msgspec.inspect.BytesType():
            return b"\x00\xff"
        case msgspec.inspect.BoolType():
            return True
        case msgspec.inspect.ListType():
            return [example(kind.item_type)]
        case msgspec.inspect.StructType():
            return full(kind.cls)
        case msgspec.inspect.DictType():
            return {example(kind.key_type): example(kind.value_type)}
        case msgspec.inspect.UnionType():
            return example(kind.types[0])
        case msgspec.inspect.VarTupleType():
            return (example(kind.item_type),)
        case msgspec.inspect.TupleType():
            return tuple(map(example, kind.item_types))
        case msgspec.inspect.FloatType():
            low, high = kind.ge or -math.inf, kind.le if kind.le is not None else math.inf
            return min(max(0.5, low), high)
        case _:
            return 7


def full(shape: type[msgspec.Struct]) -> msgspec.Struct:
    info = msgspec.inspect.type_info(shape)
    assert isinstance(info, msgspec.inspect.StructType)
    return shape(**{each.name: example(each.type) for each in info.fields})


@pytest.mark.parametrize(
    ("codec", "shape"), shapes(), ids=lambda each: getattr(each, "__name__", "")
)
def test_every_message_says_the_same_in_both_forms_and_survives_a_newer_peer(
    codec: Codec, shape: type[msgspec.Struct]
) -> None:
    message = full(shape)
    assert codec.decode(codec.encode(message)) == message
    assert codec.decode(codec.encode_text(message)) == message
    newer = msgspec.msgpack.decode(codec.encode(message)) | {"later": {"deep": [1, None]}}
    assert codec.decode(msgspec.msgpack.encode(newer)) == message


@pytest.mark.parametrize(
    ("codec", "shape"), shapes(), ids=lambda each: getattr(each, "__name__", "")
)
def test_every_message_of_an_older_peer_that_knows_no_optional_field_is_read(
    codec: Codec, shape: type[msgspec.Struct]
) -> None:
    info = msgspec.inspect.type_info(shape)
    assert isinstance(info, msgspec.inspect.StructType)
    fields = {each.name: example(each.type) for each in info.fields if each.required}
    older = msgspec.to_builtins(fields, builtin_types=(bytes,)) | {"t": info.tag}
    assert codec.decode(msgspec.msgpack.encode(older)) == shape(**fields)


# What the first version wrote, byte for byte: every message with every field it had.
RECORDED = json.loads((Path(__file__).parent / "recorded" / "first.json").read_text())
# What it called them, and what they are called now.
NAMES_NOW = {
    ("browser", "Command"): "PageCommand",
    ("browser", "CommandNews"): "CommandUpdate",
    ("browser", "Drive"): "PageDrive",
    ("browser", "DriveNews"): "DriveUpdate",
    ("browser", "Ended"): "SessionEnded",
    ("browser", "EventNews"): "EventUpdate",
    ("browser", "Lease"): "PageLease",
    ("browser", "LeaseNews"): "LeaseUpdate",
    ("browser", "Ping"): "PagePing",
    ("browser", "Pong"): "PagePong",
    ("browser", "Problem"): "RequestError",
    ("browser", "Reset"): "PageReset",
    ("browser", "ResetKey"): "ResetTokenUpdate",
    ("browser", "Shot"): "CameraPicture",
    ("browser", "Shown"): "PictureShown",
    ("browser", "SiteNews"): "SiteUpdate",
    ("browser", "Stop"): "PageStop",
    ("browser", "StopNews"): "StopUpdate",
    ("browser", "TickNews"): "TickUpdate",
    ("gateway", "CommandAsk"): "CommandRequest",
    ("gateway", "Drive"): "DriveFrame",
    ("gateway", "Gap"): "SampleGap",
    ("gateway", "LeaseAsk"): "LeaseRequest",
    ("gateway", "Picture"): "PictureFrame",
    ("gateway", "ResetAsk"): "ResetRequest",
    ("gateway", "Samples"): "SampleBatch",
    ("gateway", "StopAsk"): "StopRequest",
    ("gateway", "Tick"): "ControlTick",
    ("gateway", "Watch"): "StreamSubscription",
}


@pytest.mark.parametrize("row", RECORDED, ids=[f"{x['way']}-{x['kind']}" for x in RECORDED])
def test_what_the_first_version_said_is_understood_to_the_last_field(row: dict[str, str]) -> None:
    ways = [
        "FromGateway", "FromHub", "MediaFromGateway", "MediaFromHub",
        "FromBrowser", "ToBrowser", "MediaToBrowser", "MediaFromBrowser",
    ]  # fmt: skip
    data = bytes.fromhex(row["frame"])
    message = CODECS[ways.index(row["way"])].decode(data)
    room = "browser" if "Browser" in row["way"] else "gateway"
    assert type(message).__name__ == NAMES_NOW.get((room, row["kind"]), row["kind"])
    said = msgspec.msgpack.decode(data)
    assert said.pop("t") == message.__struct_config__.tag
    names = {each.encode_name: each.name for each in msgspec.structs.fields(message)}
    for key, value in said.items():
        now = getattr(message, names[key])
        assert msgspec.to_builtins(now, builtin_types=(bytes,)) == value, key


def test_a_kind_of_a_later_version_is_told_apart_from_garbage() -> None:
    later = {"t": "from_the_future", "x": 1}
    for data in (msgspec.msgpack.encode(later), msgspec.json.encode(later).decode()):
        with pytest.raises(UnknownKind, match="from_the_future"):
            frames.LINK_FROM_HUB.decode(data)
    with pytest.raises(PeerError) as caught:
        frames.LINK_FROM_HUB.decode(msgspec.msgpack.encode({"t": "ack", "boot": 5}))
    assert not isinstance(caught.value, UnknownKind)


def test_one_version_more_or_less_is_spoken() -> None:
    assert [each for each in range(PROTOCOL + 4) if is_compatible(each)] == [
        PROTOCOL - 1, PROTOCOL, PROTOCOL + 1
    ]  # fmt: skip
