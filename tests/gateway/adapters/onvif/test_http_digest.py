"""HTTP digest, judged by the examples of RFC 7616 with the method that ONVIF has."""

from __future__ import annotations

import re

import pytest
from hypothesis import given, strategies as st

from talaia.gateway.adapters.onvif.http_digest import authorization_of, best_challenge

pytestmark = pytest.mark.pure

REALM = 'realm="http-auth@example.org", qop="auth, auth-int"'
NONCE = 'nonce="7ypf/xlj9XXwfDPEoM4URrv/xwf94BcCAzFZH4GiTo0v"'
OPAQUE = 'opaque="FQhe/qaU925kfnzjCev0ciny7QMkPqMAFRtzCUYo5tdS"'
MD5 = f"Digest {REALM}, algorithm=MD5, {NONCE}, {OPAQUE}"
SHA = f"Digest {REALM}, algorithm=SHA-256, {NONCE}, {OPAQUE}"


def test_the_stronger_of_two_challenges_is_answered_and_basic_never() -> None:
    chosen = best_challenge([MD5, 'Basic realm="x"', SHA])
    assert chosen is not None
    assert (chosen.algorithm, chosen.realm, chosen.qop) == (
        "SHA-256",
        "http-auth@example.org",
        True,
    )
    assert best_challenge(['Basic realm="x"', "Digest realm=x", "Bearer"]) is None
    assert (
        best_challenge(['Digest nonce="n", qop="auth-int"', 'Digest nonce="n", algorithm=MD4'])
        is None
    )


@pytest.mark.parametrize(
    ("challenge", "response"),
    [
        (MD5, "8ca523f5e9506fed4657c9700eebdbec"),
        (SHA, "753927fa0e85d155564e2e272a28d1802ca10daf4496794697cf8db5856cb6c1"),
    ],
)
def test_the_answer_is_that_of_the_standard(challenge: str, response: str) -> None:
    chosen = best_challenge([challenge])
    assert chosen is not None
    # RFC 7616, 3.9.1.
    answer = authorization_of(
        chosen,
        "Mufasa",
        "Circle of Life",
        path="/dir/index.html",
        count=1,
        cnonce="f2/wE4q74E6zIJEtWaHKaf5wv/H5QzzpXusqGemxURZJ",
        method="GET",
    )
    assert f'response="{response}"' in answer
    assert "nc=00000001" in answer
    assert 'opaque="FQhe/qaU925kfnzjCev0ciny7QMkPqMAFRtzCUYo5tdS"' in answer
    assert "Circle" not in answer


@given(st.lists(st.text(max_size=80), max_size=4), st.text(max_size=20), st.text(max_size=20))
def test_whatever_is_asked_the_answer_is_one_line(
    words: list[str], user: str, password: str
) -> None:
    headers = [f'Digest nonce="{word}", realm="{word}", {word}' for word in words]
    chosen = best_challenge(headers)
    if chosen is not None:
        said = authorization_of(chosen, user, password, path="/", count=1, cnonce="c")
        assert not re.search(r"[\r\n\0]", said)
