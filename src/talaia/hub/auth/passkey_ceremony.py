"""What browsers are asked for a passkey, and whether their answers hold (WebAuthn).

The library is loaded when somebody uses a passkey, and not at each start of a hub.
"""

from __future__ import annotations

import base64
import binascii
import hashlib
import ipaddress
import json
from typing import TYPE_CHECKING, Any, NamedTuple

from talaia.hub.errors import PasskeyRefused

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

__all__ = [
    "RegisteredPasskey",
    "RelyingParty",
    "challenge_of",
    "creation_options",
    "request_options",
    "user_handle",
    "verify_answer",
    "verify_registration",
]

_TIMEOUT_MS = 120_000
_NAME = "Talaia"  # what authenticators show


class RelyingParty(NamedTuple):
    """The hub as the browser has it in its address bar."""

    host: str
    origin: str

    @property
    def can_have_passkeys(self) -> bool:
        """Whether browsers make passkeys for it: they want a name, and no IP address."""
        try:
            ipaddress.ip_address(self.host)
        except ValueError:
            return True
        return False


class RegisteredPasskey(NamedTuple):
    """The public half of a new passkey."""

    credential_id: str
    public_key: str
    sign_count: int


def user_handle(user: int) -> bytes:
    """Name a person to their authenticator, without saying who it is."""
    # Always the same for one person, so that an authenticator keeps one key for each.
    return hashlib.sha256(f"talaia person {user}".encode()).digest()


def creation_options(
    address: RelyingParty, challenge: bytes, *, user: int, name: str, have: Iterable[str]
) -> dict[str, Any]:
    """Give what ``navigator.credentials.create`` takes, as JSON; ``have`` are not made anew."""
    import webauthn
    from webauthn.helpers import structs

    made = webauthn.generate_registration_options(
        rp_id=address.host,
        rp_name=_NAME,
        user_name=name,
        user_id=user_handle(user),
        challenge=challenge,
        timeout=_TIMEOUT_MS,
        # A key that names itself signs in without a name; a plain one is a second factor still.
        authenticator_selection=structs.AuthenticatorSelectionCriteria(
            resident_key=structs.ResidentKeyRequirement.PREFERRED,
            user_verification=structs.UserVerificationRequirement.PREFERRED,
        ),
        exclude_credentials=[_descriptor(credential_id) for credential_id in have],
    )
    return _as_json(webauthn.options_to_json(made))


def request_options(
    address: RelyingParty, challenge: bytes, *, known: Iterable[str], verified: bool
) -> dict[str, Any]:
    """Give what ``navigator.credentials.get`` takes, as JSON.

    ``known``: ids of the keys that may answer; none: any that the browser has for this hub.
    """
    import webauthn
    from webauthn.helpers import structs

    need = structs.UserVerificationRequirement
    made = webauthn.generate_authentication_options(
        rp_id=address.host,
        challenge=challenge,
        timeout=_TIMEOUT_MS,
        allow_credentials=[_descriptor(credential_id) for credential_id in known],
        user_verification=need.REQUIRED if verified else need.PREFERRED,
    )
    return _as_json(webauthn.options_to_json(made))


def challenge_of(credential: Mapping[str, Any]) -> bytes:
    """Read which challenge an answer is to; the answer itself is not looked at yet.

    Raises:
        PasskeyRefused: it is no answer.

    """
    try:
        data = json.loads(_decode(credential["response"]["clientDataJSON"]))
        return _decode(data["challenge"])
    except (KeyError, TypeError, ValueError, AttributeError, RecursionError) as error:
        raise PasskeyRefused("this is no answer of a passkey", "try again") from error


def verify_registration(
    address: RelyingParty, challenge: bytes, credential: Mapping[str, Any]
) -> RegisteredPasskey:
    """Check the answer of a browser that has made a passkey.

    Raises:
        PasskeyRefused: it does not hold.

    """
    import webauthn

    try:
        made = webauthn.verify_registration_response(
            credential=dict(credential),
            expected_challenge=challenge,
            expected_rp_id=address.host,
            expected_origin=address.origin,
        )
    # Foreign bytes: whatever its decoders trip over means that the answer does not hold.
    except Exception as error:
        raise PasskeyRefused("the passkey could not be checked", "try again") from error
    return RegisteredPasskey(
        _encode(made.credential_id), _encode(made.credential_public_key), made.sign_count
    )


def verify_answer(
    address: RelyingParty,
    challenge: bytes,
    credential: Mapping[str, Any],
    *,
    kept: RegisteredPasskey,
    verified: bool,
) -> tuple[int, bool]:
    """Check a passkey's signature; give its new count, and whether its device verified the person.

    Raises:
        PasskeyRefused: it does not hold, or ``verified`` and nobody was.

    """
    import webauthn

    try:
        found = webauthn.verify_authentication_response(
            credential=dict(credential),
            expected_challenge=challenge,
            expected_rp_id=address.host,
            expected_origin=address.origin,
            credential_public_key=_decode(kept.public_key),
            credential_current_sign_count=kept.sign_count,
            require_user_verification=verified,
        )
    # As above.
    except Exception as error:
        raise PasskeyRefused("the passkey's answer is wrong", "try again") from error
    return found.new_sign_count, found.user_verified


def _descriptor(credential_id: str) -> Any:  # noqa: ANN401 - the library's, which is loaded late
    from webauthn.helpers import structs

    return structs.PublicKeyCredentialDescriptor(id=_decode(credential_id))


def _as_json(text: str) -> dict[str, Any]:
    made: dict[str, Any] = json.loads(text)
    return made


def _encode(raw: bytes) -> str:
    return base64.urlsafe_b64encode(raw).rstrip(b"=").decode()


def _decode(text: str) -> bytes:
    """Read base64url without its padding.

    Raises:
        ValueError: it is none.

    """
    try:
        return base64.b64decode(text + "=" * (-len(text) % 4), altchars=b"-_", validate=True)
    except binascii.Error as error:
        raise ValueError(str(error)) from error
