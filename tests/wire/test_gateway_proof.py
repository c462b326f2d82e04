"""A key is proved and not said; nothing that is recorded or stolen from the hub proves it again."""

from __future__ import annotations

import hashlib

from hypothesis import given, strategies as st

from talaia.wire.gateway_proof import (
    KeyProof,
    ResumeToken,
    cover_key,
    is_key_of,
    proof_words,
    read_challenge,
    read_next_nonce,
    read_proof,
)

KEY = "9Zb1oG0Qm5kq1f5Y8iKpN2vVb7y3cQe0aXwLrTtUuHs"
HASH = hashlib.sha256(KEY.encode()).hexdigest()
LINK = "/gateway/link"


def proof_of(key: str, nonce: str = "n1", site: str = "agv", path: str = LINK) -> KeyProof:
    return KeyProof(site, nonce, cover_key(key, nonce=nonce, site=site, path=path))


@given(st.text(st.characters(codec="ascii", categories=["L", "N"]), min_size=1, max_size=200))
def test_every_key_is_proved_and_never_said(key: str) -> None:
    proof = proof_of(key)
    assert is_key_of(proof, hashlib.sha256(key.encode()).hexdigest(), LINK)
    assert bytes.fromhex(proof.proof) != key.encode()
    assert read_proof(proof_words(proof)) == proof


def test_a_proof_is_of_one_key_one_number_one_site_and_one_path() -> None:
    proof = proof_of(KEY)
    assert is_key_of(proof, HASH, LINK)
    assert not is_key_of(proof_of(KEY + "x"), HASH, LINK)
    assert not is_key_of(proof._replace(nonce="n2"), HASH, LINK)
    assert not is_key_of(proof._replace(site="house"), HASH, LINK)
    assert not is_key_of(proof, HASH, "/gateway/media")
    assert not is_key_of(proof._replace(proof=""), HASH, LINK)


def test_the_hash_that_the_hub_keeps_proves_nothing() -> None:
    # As if it were the key, in each way that it can be written.
    for stolen in (HASH, bytes.fromhex(HASH).decode("latin-1")):
        assert not is_key_of(proof_of(stolen), HASH, LINK)


def test_what_a_gateway_was_handed_down_is_written_and_read() -> None:
    proof = proof_of(KEY)._replace(place=ResumeToken(7, 9), resume="ab12")
    assert read_proof(proof_words(proof)) == proof
    assert read_proof(proof_words(KeyProof("agv"))) == KeyProof("agv")


@given(st.text(max_size=300))
def test_whatever_a_stranger_says_is_read_or_passed_over(said: str) -> None:
    for text in (said, f"Talaia {said}", f"Talaia site=agv, nonce=n, proof=00, resume={said}"):
        read_proof(text)
        read_challenge(text)
        read_next_nonce(text)


def test_half_a_proof_is_none() -> None:
    for text in (
        "Bearer abc",
        "Talaia nonce=n",
        "Talaia site=agv, nonce=n",
        "Talaia site=agv, proof=00",
        "Talaia site=agv, nonce=n, proof=0",
        "Talaia site=agv, nonce=n, proof=00, resume=1.2",
        "Talaia site=agv, nonce=n, proof=00, resume=1.2.zz",
        f"Talaia site=agv, nonce=n, proof={'00' * 600}",
    ):
        assert read_proof(text) is None
