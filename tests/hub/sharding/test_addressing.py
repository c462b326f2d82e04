"""What a request says of its site decides which shard it is led to."""

from __future__ import annotations

import pytest
from hypothesis import given, strategies as st

from talaia.hub.policy_routes import CLIENT_SOCKETS, ROUTES, SOCKETS
from talaia.hub.sharding.addressing import Address, AskedObject, read_address
from talaia.wire.gateway_proof import KeyProof, proof_words


def http(path: str, query: bytes = b"", **headers: str) -> dict[str, object]:
    return {"type": "http", "path": path, "query_string": query, "headers": raw(headers)}


def socket(path: str, query: bytes = b"", **headers: str) -> dict[str, object]:
    return {"type": "websocket", "path": path, "query_string": query, "headers": raw(headers)}


def raw(headers: dict[str, str]) -> list[tuple[bytes, bytes]]:
    return [(name.encode(), value.encode()) for name, value in headers.items()]


def test_every_route_with_a_site_in_its_path_goes_to_the_shard_of_that_site() -> None:
    for _, path in ROUTES:
        about = read_address(http(path.replace("{site}", "agv").replace("{gateway}", "7")))
        if "{site}" in path:
            assert about == Address(AskedObject.SITE, "agv"), path
        elif "{gateway}" in path:
            assert about == Address(AskedObject.GATEWAY, "7"), path
        else:
            assert about == Address(AskedObject.HUB), path


def test_every_socket_goes_to_the_shard_of_the_site_that_it_names() -> None:
    for path in SOCKETS:
        about = read_address(socket(path, b"site=agv&stream=base/front")).about
        expected = AskedObject.SITE if path.startswith("/ws/") else AskedObject.HUB
        assert about is (AskedObject.PAGE if path == "/ws" else expected), path
    for path in CLIENT_SOCKETS:
        named = socket(path.replace("{site}", "agv"), b"site=agv")
        assert read_address(named) == Address(AskedObject.SITE, "agv"), path


@pytest.mark.parametrize("path", ["/gateway/link", "/gateway/media", "/gateway/files"])
def test_a_gateway_says_its_site_or_its_key_as_it_dials(path: str) -> None:
    proof = KeyProof("agv", "n0nce", "ab12")
    assert read_address(socket(path, authorization=proof_words(proof))).name == "agv"
    # Before it was asked for a proof.
    first = read_address(socket(path, authorization=proof_words(KeyProof("agv"))))
    assert first == Address(AskedObject.NEW_SITE, "agv")
    of_before = read_address(socket(path, authorization="Bearer  s3cret"))
    assert of_before == Address(AskedObject.KEY, "s3cret")
    assert read_address(socket(path)) == Address(AskedObject.HUB)


def test_of_a_site_that_is_said_twice_the_last_counts_as_for_the_routes() -> None:
    twice = socket("/ws/media", b"site=moon&stream=a/b&site=agv")
    assert read_address(twice) == Address(AskedObject.SITE, "agv")
    assert read_address(socket("/ws/media", b"stream=a/b")) == Address(AskedObject.HUB)


@given(path=st.text(), query=st.binary(max_size=40), header=st.binary(max_size=60))
def test_nothing_that_is_asked_breaks_it(path: str, query: bytes, header: bytes) -> None:
    for kind in ("http", "websocket"):
        headers = [(b"authorization", header)]
        read_address({"type": kind, "path": path, "query_string": query, "headers": headers})
