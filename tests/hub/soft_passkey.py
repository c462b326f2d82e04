"""A passkey in a few lines, as a browser with an authenticator answers: ES256, no attestation."""

from __future__ import annotations

import base64
import hashlib
import json
import secrets

import cbor2
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec

_PRESENT, _VERIFIED, _ATTESTED = 0x01, 0x04, 0x40


def to_text(raw: bytes) -> str:
    return base64.urlsafe_b64encode(raw).rstrip(b"=").decode()


class SoftPasskey:
    """Answers what a hub asks. What an attacker would change can be said each time."""

    def __init__(self) -> None:  # noqa: D107
        self.key = ec.generate_private_key(ec.SECP256R1())
        self.id = secrets.token_bytes(32)
        # Says 0 unless told to count, as most do.
        self.count = 0

    def create(self, options: dict, origin: str, *, host: str = "localhost") -> dict:
        numbers = self.key.public_key().public_numbers()
        public = {
            1: 2, 3: -7, -1: 1, -2: numbers.x.to_bytes(32, "big"), -3: numbers.y.to_bytes(32, "big")
        }  # fmt: skip
        attested = bytes(16) + len(self.id).to_bytes(2, "big") + self.id + cbor2.dumps(public)
        data = self._data(host, _PRESENT | _VERIFIED | _ATTESTED) + attested
        made = {"fmt": "none", "attStmt": {}, "authData": data}
        client = self._client("webauthn.create", options, origin)
        return self._answer(clientDataJSON=client, attestationObject=cbor2.dumps(made))

    def get(
        self, options: dict, origin: str, *, host: str = "localhost", verified: bool = True
    ) -> dict:
        data = self._data(host, _PRESENT | (_VERIFIED if verified else 0))
        client = self._client("webauthn.get", options, origin)
        signed = data + hashlib.sha256(client).digest()
        signature = self.key.sign(signed, ec.ECDSA(hashes.SHA256()))
        return self._answer(clientDataJSON=client, authenticatorData=data, signature=signature)

    def _data(self, host: str, flags: int) -> bytes:
        return (
            hashlib.sha256(host.encode()).digest() + bytes([flags]) + self.count.to_bytes(4, "big")
        )

    @staticmethod
    def _client(kind: str, options: dict, origin: str) -> bytes:
        said = {"type": kind, "challenge": options["challenge"], "origin": origin}
        return json.dumps(said).encode()

    def _answer(self, **response: bytes) -> dict:
        said = {name: to_text(raw) for name, raw in response.items()}
        named = to_text(self.id)
        return {"id": named, "rawId": named, "type": "public-key", "response": said}
