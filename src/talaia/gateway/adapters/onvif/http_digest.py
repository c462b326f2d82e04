"""HTTP digest, with which newer cameras are signed in at. Pure.

After RFC 7616: MD5 and SHA-256, ``qop=auth``. The password itself is never sent: a server that
asks for it in plain (basic) does not get it.
"""

from __future__ import annotations

import hashlib
import re
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["DigestChallenge", "authorization_of", "best_challenge"]

_PAIR = re.compile(r'([A-Za-z0-9_-]{1,40})\s*=\s*(?:"((?:[^"\\]|\\.){0,1000})"|([^\s,"]{1,1000}))')
# By what a server calls it, the strongest first.
_ALGORITHMS = {"SHA-256": "sha256", "MD5": "md5"}


class DigestChallenge(NamedTuple):
    """What a server wants to be answered."""

    realm: str
    nonce: str
    opaque: str
    algorithm: str
    qop: bool


def best_challenge(headers: Iterable[str]) -> DigestChallenge | None:
    """Choose the strongest challenge of ``WWW-Authenticate`` headers; none where none is known."""
    found: dict[str, DigestChallenge] = {}
    for header in headers:
        scheme, _, rest = header.strip().partition(" ")
        if scheme.lower() != "digest":
            continue
        words = {
            key.lower(): (quoted or plain).replace("\\", "")
            for key, quoted, plain in _PAIR.findall(rest)
        }
        algorithm = words.get("algorithm", "MD5").upper()
        offers = [offer.strip() for offer in words.get("qop", "").split(",")]
        # Only ``auth-int`` is left: it would sign the body, which no camera is known to ask for.
        if algorithm not in _ALGORITHMS or "nonce" not in words or offers == ["auth-int"]:
            continue
        challenge = DigestChallenge(
            words.get("realm", ""),
            words["nonce"],
            words.get("opaque", ""),
            algorithm,
            "auth" in offers,
        )
        found.setdefault(algorithm, challenge)
    return next((found[name] for name in _ALGORITHMS if name in found), None)


def authorization_of(
    challenge: DigestChallenge,
    user: str,
    password: str,
    *,
    path: str,
    count: int,
    cnonce: str,
    method: str = "POST",
) -> str:
    """Answer a challenge.

    Args:
        challenge: the server's.
        user: who signs in.
        password: theirs.
        path: what is asked, as in the request's first line.
        count: how often this challenge has been answered, from 1.
        cnonce: a random word of ours.
        method: of the request.

    """

    def hashed(text: str) -> str:
        return hashlib.new(
            _ALGORITHMS[challenge.algorithm], text.encode(), usedforsecurity=False
        ).hexdigest()

    who = hashed(f"{user}:{challenge.realm}:{password}")
    what = hashed(f"{method}:{path}")
    number = f"{count:08x}"
    middle = f"{challenge.nonce}:{number}:{cnonce}:auth" if challenge.qop else challenge.nonce
    parts = [
        f'username="{_quoted(user)}"',
        f'realm="{_quoted(challenge.realm)}"',
        f'nonce="{_quoted(challenge.nonce)}"',
        f'uri="{path}"',
        f"algorithm={challenge.algorithm}",
        f'response="{hashed(f"{who}:{middle}:{what}")}"',
    ]
    if challenge.opaque:
        parts.append(f'opaque="{_quoted(challenge.opaque)}"')
    if challenge.qop:
        parts += ["qop=auth", f"nc={number}", f'cnonce="{cnonce}"']
    return f"Digest {', '.join(parts)}"


def _quoted(text: str) -> str:
    # A line break would begin another header; `http.client` refuses it as well.
    plain = "".join(letter for letter in text if letter.isprintable())
    return plain.replace("\\", "\\\\").replace('"', '\\"')
