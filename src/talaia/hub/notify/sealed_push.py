"""A message that a browser's push service passes on and cannot read, and who vouches for it. Pure.

Sources: RFC 8291 (encryption for Web Push), RFC 8188 (its form, ``aes128gcm``), RFC 8292 (VAPID).
"""

from __future__ import annotations

import base64
import json
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.asymmetric.utils import decode_dss_signature
from cryptography.hazmat.primitives.ciphers.aead import AESGCM
from cryptography.hazmat.primitives.hashes import SHA256
from cryptography.hazmat.primitives.kdf.hkdf import HKDF
from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["seal_message", "vouch_for"]

_CURVE = ec.SECP256R1()
# Of one record; the message is one (bytes; RFC 8291, 4).
_RECORD = 4096
# Of the secret that a browser gives (bytes; RFC 8291, 3.2).
_SECRET = 16
# What follows the message in its last record (RFC 8188, 2).
_LAST = b"\x02"
# A push service need not take a word that is good for longer than a day (RFC 8292, 2; s).
_GOOD_FOR_S = 12 * 3600


def seal_message(
    message: bytes,
    subscription: Mapping[str, str],
    sender: ec.EllipticCurvePrivateKey,
    salt: bytes,
) -> bytes:
    """Seal a message for a browser.

    Args:
        message: at most 3993 bytes.
        subscription: the browser's ``p256dh`` and ``auth``.
        sender: a key made for this message alone.
        salt: 16 random bytes for this message alone.

    Raises:
        ValueError: the browser's keys are none, or the message is too long.

    """
    if len(message) > _RECORD - 17 - 86:
        raise ValueError(f"a message of {len(message)} bytes is too long to be pushed")
    their_point, secret = (_decode_base64(subscription[name]) for name in ("p256dh", "auth"))
    if len(secret) != _SECRET:
        raise ValueError(f"a browser's secret has {len(secret)} bytes; expected {_SECRET}")
    theirs = ec.EllipticCurvePublicKey.from_encoded_point(_CURVE, their_point)
    own_point = _point_of(sender)
    shared = sender.exchange(ec.ECDH(), theirs)
    about = b"WebPush: info\0" + their_point + own_point
    material = _derive(shared, secret, about, 32)
    key = _derive(material, salt, b"Content-Encoding: aes128gcm\0", 16)
    nonce = _derive(material, salt, b"Content-Encoding: nonce\0", 12)
    sealed = AESGCM(key).encrypt(nonce, message + _LAST, None)
    head = salt + _RECORD.to_bytes(4, "big") + len(own_point).to_bytes(1, "big") + own_point
    return head + sealed


def vouch_for(endpoint: str, subject: str, private_key: str, now_s: float) -> str:
    """Give the ``Authorization`` by which a push service knows whose messages these are.

    Args:
        endpoint: the browser's address at its push service.
        subject: whom the service may write to, ``mailto:…``.
        private_key: of this hub (base64 of its number).
        now_s: since the epoch (UTC).

    Raises:
        ValueError: the key is none.

    """
    key = ec.derive_private_key(int.from_bytes(_decode_base64(private_key), "big"), _CURVE)
    parts = urlsplit(endpoint)
    said = {
        "aud": f"{parts.scheme}://{parts.netloc}",
        "exp": int(now_s) + _GOOD_FOR_S,
        "sub": subject,
    }
    words = ({"typ": "JWT", "alg": "ES256"}, said)
    text = ".".join(_encode_base64(json.dumps(part).encode()) for part in words)
    signature = key.sign(text.encode(), ec.ECDSA(SHA256()))
    # JSON Web Signatures have both numbers beside each other (RFC 7518, 3.4).
    numbers = b"".join(number.to_bytes(32, "big") for number in decode_dss_signature(signature))
    return f"vapid t={text}.{_encode_base64(numbers)}, k={_encode_base64(_point_of(key))}"


def _derive(secret: bytes, salt: bytes, about: bytes, length: int) -> bytes:
    return HKDF(SHA256(), length, salt, about).derive(secret)


def _point_of(key: ec.EllipticCurvePrivateKey) -> bytes:
    return key.public_key().public_bytes(Encoding.X962, PublicFormat.UncompressedPoint)


def _encode_base64(raw: bytes) -> str:
    return base64.urlsafe_b64encode(raw).decode().rstrip("=")


def _decode_base64(text: str) -> bytes:
    # Of wrong padding it raises a kind of `ValueError`; other signs it passes over.
    return base64.urlsafe_b64decode(text + "=" * (-len(text) % 4))
