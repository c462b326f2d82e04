"""How a gateway proves that it holds its key, and was linked before, and says neither. Pure.

The hub asks with a number that it uses once. The answer to the key is SCRAM's (RFC 5802): the key,
covered by an HMAC under the key's SHA-256. The hub, which keeps that hash and not the key, takes
the cover off and looks whether the hash fits; from a recorded answer nobody learns the key, and a
stolen hash answers nothing. What the hub has handed down on the last link it can make again by
itself, so there a plain HMAC will do.

Both answers are bound to the asker's number, the site and the path: one that was recorded opens
nothing, at this hub or another.
"""

from __future__ import annotations

import hashlib
import hmac
import re
from typing import NamedTuple

__all__ = [
    "NO_PLACE",
    "SCHEME",
    "KeyProof",
    "ResumeToken",
    "challenge_words",
    "cover_key",
    "is_key_of",
    "next_nonce_words",
    "proof_words",
    "read_challenge",
    "read_next_nonce",
    "read_proof",
    "resume_answer",
]

# Of `Authorization` and `WWW-Authenticate`.
SCHEME = "Talaia"
# Longer keys and headers are none of ours.
_MOST_KEY = 512
_MOST_HEADER = 4_096
# What a parameter may hold without quotes (a token of RFC 9110, and no more than we write).
_WORD = r"[A-Za-z0-9._~\-]+"
_PARAMETERS = re.compile(rf"{_WORD}={_WORD}(?:, ?{_WORD}={_WORD})*")
_NUMBER = re.compile(r"[0-9]{1,17}")


class ResumeToken(NamedTuple):
    """Which place a gateway had: both numbers are the hub's own, and rise.

    Attributes:
        lineage: of the first link of this gateway, from which each later one came; 0: of none.
        serial: of the last link.

    """

    lineage: int = 0
    serial: int = 0


# Of a gateway that was never linked, or cannot show it.
NO_PLACE = ResumeToken()


class KeyProof(NamedTuple):
    """What a gateway says of itself as it dials.

    Attributes:
        site: for which its key is.
        nonce: the hub's number that it answers; empty: it asks for one.
        proof: the key under its cover, in hex.
        place: what it was handed down on its last link.
        resume: the answer that shows it, in hex; empty: it has none.

    """

    site: str
    nonce: str = ""
    proof: str = ""
    place: ResumeToken = NO_PLACE
    resume: str = ""


def cover_key(key: str, *, nonce: str, site: str, path: str) -> str:
    """Give a key under its cover, in hex: `KeyProof.proof`."""
    plain = key.encode()
    return _covered(plain, hashlib.sha256(plain).digest(), (nonce, site, path)).hex()


def is_key_of(proof: KeyProof, key_hash: str, path: str) -> bool:
    """Tell whether who made a proof holds the key of which this is the SHA-256 (hex)."""
    stored = bytes.fromhex(key_hash)
    covered = bytes.fromhex(proof.proof)
    # The cover is its own inverse.
    key = _covered(covered, stored, (proof.nonce, proof.site, path))
    return hmac.compare_digest(hashlib.sha256(key).digest(), stored)


def resume_answer(secret: bytes, *, nonce: str, site: str, path: str) -> str:
    """Give the answer that shows the secret handed down on the last link: `KeyProof.resume`."""
    return _mac(secret, b"talaia resume", (nonce, site, path)).hex()


def _covered(data: bytes, stored: bytes, bound: tuple[str, ...]) -> bytes:
    blocks = range(-(-len(data) // hashlib.sha256().digest_size))
    # One block is shorter than a key as it is written.
    cover = b"".join(_mac(stored, b"talaia key %d" % block, bound) for block in blocks)
    return bytes(left ^ right for left, right in zip(data, cover, strict=False))


def _mac(key: bytes, purpose: bytes, bound: tuple[str, ...]) -> bytes:
    parts = (purpose, *(part.encode() for part in bound))
    # Each with its length before it, so that no two sayings are the same bytes.
    said = b"".join(b"%d:%s" % (len(part), part) for part in parts)
    return hmac.new(key, said, hashlib.sha256).digest()


def proof_words(said: KeyProof) -> str:
    """Write a proof as `Authorization` has it."""
    words = {"site": said.site}
    if said.nonce:
        words |= {"nonce": said.nonce, "proof": said.proof}
    if said.resume:
        words["resume"] = f"{said.place.lineage}.{said.place.serial}.{said.resume}"
    return f"{SCHEME} " + ", ".join(f"{name}={value}" for name, value in words.items())


def read_proof(header: str) -> KeyProof | None:
    """Read `Authorization`; None: it is no proof, or none of ours."""
    words = _read_words(header)
    site, nonce, proof = (words.get(name, "") for name in ("site", "nonce", "proof"))
    if not site or len(proof) > 2 * _MOST_KEY or not _is_hex(proof) or bool(nonce) != bool(proof):
        return None
    place, resume = NO_PLACE, words.get("resume", "")
    if resume:
        lineage, _, rest = resume.partition(".")
        serial, _, resume = rest.partition(".")
        numbers = _NUMBER.fullmatch(lineage) and _NUMBER.fullmatch(serial)
        if not (numbers and resume and _is_hex(resume)):
            return None
        place = ResumeToken(int(lineage), int(serial))
    return KeyProof(site, nonce, proof, place, resume)


def challenge_words(nonce: str) -> str:
    """Write what the hub asks as `WWW-Authenticate` has it."""
    return f"{SCHEME} nonce={nonce}"


def read_challenge(header: str) -> str:
    """Read the hub's number out of `WWW-Authenticate`; empty: this hub asks for no proof."""
    return _read_words(header).get("nonce", "")


def next_nonce_words(nonce: str) -> str:
    """Write the number for the next connection as `Authentication-Info` has it (RFC 7615)."""
    return f"nextnonce={nonce}"


def read_next_nonce(header: str) -> str:
    """Read the number for the next connection; empty: there is none."""
    return _read_words(f"{SCHEME} {header}").get("nextnonce", "")


def _read_words(header: str) -> dict[str, str]:
    scheme, _, rest = header.partition(" ")
    if scheme.lower() != SCHEME.lower() or len(header) > _MOST_HEADER:
        return {}
    if not _PARAMETERS.fullmatch(rest.strip()):
        return {}
    pairs = (word.strip().partition("=") for word in rest.split(","))
    return {name.lower(): value for name, _, value in pairs}


def _is_hex(text: str) -> bool:
    try:
        # Without spaces, which `fromhex` would pass over.
        return len(bytes.fromhex(text)) * 2 == len(text)
    except ValueError:
        return False
