"""Files by their content on the hub's disk: found by name, bounded, and never another's."""

from __future__ import annotations

import hashlib
import os

import pytest

from talaia.hub.live.assets.asset_cache import AssetCache

URI = "package://arm/hand.stl"


def keep(cache: AssetCache, folder, data: bytes, site: str = "agv") -> str:
    path = folder / "coming"
    path.write_bytes(data)
    digest = hashlib.sha256(data).hexdigest()
    cache.keep_file(site, digest, path)
    return digest


@pytest.fixture
def cache(tmp_path):
    return AssetCache(tmp_path / "meshes", 100)


def test_file_is_found_by_its_name_also_by_another_run(cache, tmp_path) -> None:
    assert cache.find_digest("agv", URI) == ""
    digest = keep(cache, tmp_path, b"solid")
    cache.name_file("agv", URI, digest)
    again = AssetCache(tmp_path / "meshes", 100)
    assert again.find_digest("agv", URI) == digest
    assert again.read_file("agv", digest) == b"solid"


def test_no_site_has_what_another_sites_gateway_brought(cache, tmp_path) -> None:
    digest = keep(cache, tmp_path, b"solid")
    cache.name_file("agv", URI, digest)
    assert not cache.has_file("moon", digest)
    assert cache.read_file("moon", digest) is None
    assert cache.find_digest("moon", URI) == ""


def test_what_was_read_longest_ago_goes_first(cache, tmp_path) -> None:
    digests = [keep(cache, tmp_path, bytes([number]) * 40) for number in range(2)]
    files = tmp_path / "meshes" / "agv" / "files"
    for age, digest in ((1_000, digests[0]), (2_000, digests[1])):
        os.utime(files / digest, (age, age))
    # Read now, and so used last.
    assert cache.read_file("agv", digests[0])
    newest = keep(cache, tmp_path, b"\2" * 40)
    assert [cache.has_file("agv", one) for one in (*digests, newest)] == [True, False, True]
    assert cache.find_digest("agv", URI) == ""
    # One alone that is larger than all may be stays, for whoever waits for it.
    assert cache.has_file("agv", keep(cache, tmp_path, b"\3" * 200))
    assert len(list(files.iterdir())) == 1


def test_damaged_copy_is_none(cache, tmp_path) -> None:
    digest = keep(cache, tmp_path, b"solid")
    cache.name_file("agv", URI, digest)
    (tmp_path / "meshes" / "agv" / "files" / digest).write_bytes(b"other")
    assert cache.read_file("agv", digest) is None
    assert cache.find_digest("agv", URI) == ""


@pytest.mark.parametrize("text", [b"", b"../../../etc/passwd", b"\xff" * 64, b"A" * 64])
def test_damaged_name_is_none(cache, tmp_path, text) -> None:
    cache.name_file("agv", URI, keep(cache, tmp_path, b"solid"))
    (name,) = (tmp_path / "meshes" / "agv" / "names").iterdir()
    name.write_bytes(text)
    assert cache.find_digest("agv", URI) == ""


def test_names_are_bounded(cache, tmp_path) -> None:
    digest = keep(cache, tmp_path, b"solid")
    names = tmp_path / "meshes" / "agv" / "names"
    names.mkdir()
    for number in range(5_100):
        (names / str(number)).touch()
    cache.name_file("agv", URI, digest)
    assert len(list(names.iterdir())) == 5_000
    assert cache.find_digest("agv", URI) == digest
