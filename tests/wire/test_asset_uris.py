"""Names of a robot's files: what is taken apart leads nowhere but down."""

from __future__ import annotations

import posixpath
from urllib.parse import quote

import pytest
from hypothesis import example, given, strategies as st

from talaia.wire.asset_uris import AssetUri, is_asset_name, parse_asset_uri

NAMES = [
    ("package://arm/meshes/hand.stl", AssetUri("arm", ("meshes", "hand.stl"))),
    ("package://arm/my%20meshes/h.STL", AssetUri("arm", ("my meshes", "h.STL"))),
    ("file:///opt/robot/hand.stl", AssetUri("", ("opt", "robot", "hand.stl"))),
]
NONE = [
    "",
    "package://",
    "package:///",
    "package://arm",
    "package://arm/",
    "package:///arm/hand.stl",
    "package://arm//hand.stl",
    "package://arm/../hand.stl",
    "package://arm/%2e%2e/hand.stl",
    "package://arm/..%2Fhand.stl",
    "package://arm/.hidden.stl",
    "package://../hand.stl",
    "package://arm/..\\hand.stl",
    "package://C:/hand.stl",
    "package://arm/hand.stl\0",
    "package://arm/" + "a" * 1000,
    "file://host/hand.stl",
    "file:///",
    "file:////hand.stl",
    "file:///../hand.stl",
    "http://127.0.0.1/hand.stl",
    "/etc/passwd",
]


@pytest.mark.parametrize(("uri", "name"), NAMES)
def test_name_is_taken_apart(uri, name) -> None:
    assert parse_asset_uri(uri) == name


@pytest.mark.parametrize("uri", NONE)
def test_what_is_no_name_of_a_file_is_none(uri) -> None:
    assert parse_asset_uri(uri) is None


@given(
    st.sampled_from(["package://", "file://", "package:///", "file:///", ""]),
    st.text(st.sampled_from("ab./\\%2eE:F\0\n5c ~"), max_size=30),
)
@example("package://", "a/%252e%252e/b")
def test_whatever_is_written_leads_below_where_it_begins(scheme, text) -> None:
    name = parse_asset_uri(scheme + text)
    if name is None:
        return
    path = posixpath.join("/root", *name.parts)
    assert posixpath.normpath(path) == path
    assert path.startswith("/root/")
    assert not any(part.startswith(".") for part in (name.package, *name.parts))


NAME = st.text(st.characters(categories=["L", "N", "Zs"]), min_size=1).filter(str.isprintable)


@given(st.lists(NAME, min_size=2, max_size=5))
def test_name_that_is_written_for_the_web_is_read_again(parts) -> None:
    uri = "package://" + "/".join(quote(part, safe="") for part in parts)
    if len(uri) <= 1000:
        assert parse_asset_uri(uri) == AssetUri(parts[0], tuple(parts[1:]))


def test_only_meshes_and_what_they_are_painted_with_may_be_assets() -> None:
    for name in ("a.stl", "a.STL", "a.b.dae", "a.png", "arm.urdf"):
        assert is_asset_name(name)
    for name in ("keys.pem", "stl", ".stl", "a.stl.py", "a.", "a.stl "):
        assert not is_asset_name(name)
