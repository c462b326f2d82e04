"""Sealed push messages beside RFC 8291's own example, and beside another's reading of ours."""

from __future__ import annotations

import base64
import os

import http_ece
import pytest
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat
from joserfc import jwt
from joserfc.jwk import ECKey

from talaia.hub.notify.sealed_push import seal_message, vouch_for

pytestmark = pytest.mark.pure
CURVE = ec.SECP256R1()
# RFC 8291, 5.
SAID = b"When I grow up, I want to be a watermelon"
BROWSER = {
    "p256dh": (
        "BCVxsr7N_eNgVRqvHtD0zTZsEc6-VV-JvLexhqUzORcxaOzi6-AYWXvTBHm4bjyPjs7Vd8pZGH6SRpkNtoIAiw4"
    ),
    "auth": "BTBZMqHH6r4Tts7J_aSIgg",
}
SENDER = "yfWPiYE-n46HLnH0KqZOF1fJJU3MYrct3AELtAQ-oRw"
SALT = "DGv6ra1nlYgDCS1FRnbzlw"
SEALED = (
    "DGv6ra1nlYgDCS1FRnbzlwAAEABBBP4z9KsN6nGRTbVYI_c7VJSPQTBtkgcy27mlmlMoZIIgDll6e3vCYLocInmYWAmS"
    "6TlzAC8wEqKK6PBru3jl7A_yl95bQpu6cVPTpK4Mqgkf1CXztLVBSt2Ks3oZwbuwXPXLWyouBWLVWGNWQexSgSxsj_Qu"
    "lcy4a-fN"
)


def unpack(text: str) -> bytes:
    return base64.urlsafe_b64decode(text + "=" * (-len(text) % 4))


def pack(raw: bytes) -> str:
    return base64.urlsafe_b64encode(raw).decode().rstrip("=")


def test_the_example_of_the_standard_comes_out_byte_for_byte() -> None:
    key = ec.derive_private_key(int.from_bytes(unpack(SENDER), "big"), CURVE)
    assert seal_message(SAID, BROWSER, key, unpack(SALT)) == unpack(SEALED)


@pytest.mark.parametrize("length", [0, 1, 1500, 3993])
def test_another_program_reads_what_is_sealed_for_it(length: int) -> None:
    theirs, secret = ec.generate_private_key(CURVE), os.urandom(16)
    point = theirs.public_key().public_bytes(Encoding.X962, PublicFormat.UncompressedPoint)
    browser = {"p256dh": pack(point), "auth": pack(secret)}
    message = os.urandom(length)
    sealed = seal_message(message, browser, ec.generate_private_key(CURVE), os.urandom(16))
    assert len(sealed) <= 4096
    read = http_ece.decrypt(sealed, private_key=theirs, auth_secret=secret, version="aes128gcm")
    assert read == message


@pytest.mark.parametrize(
    ("browser", "message"),
    [
        ({**BROWSER, "p256dh": "AAAA"}, SAID),
        ({**BROWSER, "auth": "!"}, SAID),
        (BROWSER, bytes(3994)),
    ],
)
def test_what_cannot_be_sealed_is_refused(browser: dict[str, str], message: bytes) -> None:
    with pytest.raises(ValueError, match=r"."):
        seal_message(message, browser, ec.generate_private_key(CURVE), bytes(16))


def test_a_push_service_can_judge_whose_message_it_is() -> None:
    own = ec.generate_private_key(CURVE)
    number = pack(own.private_numbers().private_value.to_bytes(32, "big"))
    said = vouch_for("https://push.example:8443/a/b?c", "mailto:a@example.org", number, 1e9)
    token, key = (each.partition("=")[2] for each in said.removeprefix("vapid ").split(", "))
    point = unpack(key)
    judge = ECKey.import_key(
        {"kty": "EC", "crv": "P-256", "x": pack(point[1:33]), "y": pack(point[33:])}
    )
    read = jwt.decode(token, judge, algorithms=["ES256"])
    assert read.header["alg"] == "ES256"
    assert read.claims == {
        "aud": "https://push.example:8443",
        "exp": 1_000_043_200,
        "sub": "mailto:a@example.org",
    }
