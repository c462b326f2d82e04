"""Whether an ID token holds: signature, issuer, audience, time, nonce (OpenID Connect, 3.1.3.7).

The library is loaded when somebody signs in like this, and not at each start of a hub.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from talaia.hub.errors import ProviderRefused

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["IdToken", "verify_id_token"]

# By the provider's public keys alone: neither unsigned, nor by a secret that both have.
_RSA = ("RS256", "RS384", "RS512", "PS256", "PS384", "PS512")
_ALGORITHMS = (*_RSA, "ES256", "ES384", "ES512", "EdDSA")
# Clocks of two machines differ (s).
_SLACK_S = 60
# Older than that a token was not made for this sign-in (s).
_OLDEST_S = 600
_LONGEST_SUBJECT = 255


@dataclass(frozen=True, slots=True)
class IdToken:
    """What a token says that holds.

    Attributes:
        subject: names the person at this issuer for good.
        auth_time: when they gave their password there (s since the epoch); 0: not said.
        claims: all of it.

    """

    subject: str
    auth_time: float
    claims: Mapping[str, Any]

    @property
    def verified_email(self) -> str:
        """The mail address, if the provider says that it is the person's; else empty."""
        # A text "true" is what some providers send for what nobody has looked at: not taken.
        verified = self.claims.get("email_verified") is True
        email = self.claims.get("email")
        return email if verified and isinstance(email, str) else ""

    def words_of(self, claim: str) -> set[str]:
        """Give a claim that is a text, or a list of them."""
        value = self.claims.get(claim)
        found = [value] if isinstance(value, str) else value if isinstance(value, list) else []
        return {word for word in found if isinstance(word, str)}


def verify_id_token(
    token: str, keys: Mapping[str, Any], *, issuer: str, client_id: str, nonce: str, now_s: float
) -> IdToken:
    """Check a token; ``keys`` is the provider's JSON Web Key Set.

    Raises:
        ProviderRefused: it does not hold; says why.

    """
    from joserfc import jwt
    from joserfc.jwk import KeySet

    try:
        known = KeySet.import_key_set({"keys": _signing_keys(keys)})
        said = jwt.decode(token, known, algorithms=list(_ALGORITHMS)).claims
    # Foreign bytes: whatever the library trips over means that the token does not hold.
    except Exception as error:
        raise ProviderRefused("the signature of the ID token does not hold") from error
    audience = said.get("aud")
    audiences = audience if isinstance(audience, list) else [audience]
    if said.get("iss") != issuer:
        raise ProviderRefused(f"the ID token is of the issuer {_short(said.get('iss'))}")
    if client_id not in audiences:
        raise ProviderRefused("the ID token is for another client")
    # Made for several: it has to say for whom it was made out.
    if (len(audiences) > 1 or "azp" in said) and said.get("azp") != client_id:
        raise ProviderRefused("the ID token was made out to another client")
    expires, issued = _number(said, "exp"), _number(said, "iat")
    if expires + _SLACK_S < now_s:
        raise ProviderRefused("the ID token has expired")
    if issued - _SLACK_S > now_s or issued + _OLDEST_S < now_s:
        raise ProviderRefused("the ID token was not made just now; compare the clocks")
    if not nonce or said.get("nonce") != nonce:
        raise ProviderRefused("the ID token belongs to another sign-in")
    subject = said.get("sub")
    if not isinstance(subject, str) or not 0 < len(subject) <= _LONGEST_SUBJECT:
        raise ProviderRefused("the ID token names nobody")
    auth_time = said.get("auth_time", 0)
    real = isinstance(auth_time, int | float) and not isinstance(auth_time, bool)
    return IdToken(subject, float(auth_time) if real else 0.0, said)


def _signing_keys(keys: Mapping[str, Any]) -> list[Any]:
    # Some providers have keys for encryption beside them, of kinds that no library knows.
    return [
        key
        for key in keys.get("keys", ())
        if isinstance(key, dict) and key.get("use", "sig") == "sig" and key.get("kty") != "oct"
    ]


def _number(said: Mapping[str, Any], claim: str) -> float:
    value = said.get(claim)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ProviderRefused(f"the ID token does not say {claim}")
    return float(value)


def _short(value: object) -> str:
    return repr(value)[:100]
