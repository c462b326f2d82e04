"""Asks the provider of sign-ins: what it can do, by which keys it signs, and for a code's token.

It speaks to the addresses of the administrator's own file, and to those that the provider there
names; to nobody whom a person, a gateway or a description has named. Nothing else of the hub's own
process speaks HTTP to others: what asks another address of the administrator's does it by
`ask_address`.
"""

from __future__ import annotations

import json
import ssl
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlencode, urlsplit

from talaia.clock import SECOND
from talaia.hub.errors import ProviderRefused
from talaia.hub.settings import is_loopback

if TYPE_CHECKING:
    from collections.abc import Callable

    import httpx

    from talaia.clock import Clock
    from talaia.hub.auth.oidc_settings import OidcSettings
    from talaia.hub.auth.oidc_states import AwaitedSignIn

__all__ = ["EndlessAnswer", "ProviderClient", "ask_address"]

_TIMEOUT_S = 10.0
# Of any answer (bytes); keys with certificates take some.
_MOST_ANSWER = 1024 * 1024
# What the provider said of itself is asked for anew after so long.
_KEEP_NS = 600 * SECOND
_MOST_SECRET = 10_000


class EndlessAnswer(OSError):
    """Whoever was asked answers with more than anybody waits for."""


async def ask_address(
    url: str,
    make_request: Callable[[httpx.AsyncClient], httpx.Request],
    *,
    verify: ssl.SSLContext | bool,
    timeout_s: float,
    most: int,
) -> tuple[int, bytes]:
    """Ask an address that the administrator named; give the answer's status and body.

    Args:
        url: the address.
        make_request: of the client, for ``url``.
        verify: what the other's certificate is held against; False where there is none.
        timeout_s: of each step (s).
        most: bytes of the body.

    Raises:
        EndlessAnswer: there are more.
        OSError: nobody answers.

    """
    import httpx

    # A proxy of the surroundings is the administrator's; it is none for this machine.
    trust = not is_loopback(urlsplit(url).hostname or "")
    try:
        async with httpx.AsyncClient(timeout=timeout_s, verify=verify, trust_env=trust) as client:
            # Redirects are not followed: the secret goes nowhere else.
            answer = await client.send(make_request(client), stream=True)
            body = b""
            async for piece in answer.aiter_bytes():
                body += piece
                if len(body) > most:
                    raise EndlessAnswer("it answers without end")
            await answer.aclose()
    except httpx.HTTPError as error:
        raise OSError(str(error)) from error
    return answer.status_code, body


class ProviderClient:
    """The provider, as this hub sees it."""

    def __init__(self, settings: OidcSettings, clock: Clock) -> None:
        """Speak to the provider that ``settings`` names."""
        self.settings = settings
        self._clock = clock
        # What it said of itself, and when (monotonic).
        self._found: dict[str, Any] = {}
        self._asked_ns = 0

    async def authorization_url(self, awaited: AwaitedSignIn, *, fresh_s: int = 0) -> str:
        """Give where a browser goes to sign in.

        Args:
            awaited: the sign-in.
            fresh_s: not 0: the password is to be given anew, and the token says when it was.

        Raises:
            ProviderRefused: the provider does not answer, or cannot do it.

        """
        found = await self._discover()
        asked = {
            "response_type": "code",
            "client_id": self.settings.client_id,
            "redirect_uri": awaited.redirect,
            "scope": " ".join(["openid", *self.settings.scopes]),
            "state": awaited.state,
            "nonce": awaited.nonce,
            "code_challenge": awaited.challenge,
            "code_challenge_method": "S256",
        }
        if fresh_s:
            # Only who is asked for an age says in the token when the password was given.
            asked |= {"prompt": "login", "max_age": str(fresh_s)}
        where = found["authorization_endpoint"]
        return f"{where}{'&' if urlsplit(where).query else '?'}{urlencode(asked)}"

    async def requires_issuer(self) -> bool:
        """Tell whether the provider names itself in each answer (RFC 9207)."""
        found = await self._discover()
        return found.get("authorization_response_iss_parameter_supported") is True

    async def redeem_code(self, code: str, awaited: AwaitedSignIn) -> tuple[str, dict[str, Any]]:
        """Give the ID token that a code is good for, and the provider's keys.

        Raises:
            ProviderRefused: the provider does not answer, or does not take the code.

        """
        found = await self._discover()
        answer = await self._ask(
            found["token_endpoint"],
            {
                "grant_type": "authorization_code",
                "code": code,
                "redirect_uri": awaited.redirect,
                "code_verifier": awaited.verifier,
            },
            by_post=found.get("token_endpoint_auth_methods_supported") == ["client_secret_post"],
        )
        token = answer.get("id_token")
        if not isinstance(token, str):
            raise ProviderRefused("the provider gave no ID token", "is openid among its scopes?")
        # Asked each time: a provider that changes its keys is not waited for.
        return token, await self._ask(found["jwks_uri"])

    async def _discover(self) -> dict[str, Any]:
        now_ns = self._clock.monotonic_ns()
        if self._found and now_ns - self._asked_ns < _KEEP_NS:
            return self._found
        found = await self._ask(self.settings.discovery)
        # Else one provider could speak for another (OpenID Connect Discovery, 4.3).
        if found.get("issuer") != self.settings.issuer:
            raise ProviderRefused(
                f"the provider calls itself {str(found.get('issuer'))[:200]!r}",
                "write that as issuer, if it is right",
            )
        for name in ("authorization_endpoint", "token_endpoint", "jwks_uri"):
            _check_address(name, found.get(name))
        self._found, self._asked_ns = found, now_ns
        return found

    async def _ask(
        self, url: str, form: dict[str, str] | None = None, *, by_post: bool = False
    ) -> dict[str, Any]:
        settings = self.settings
        host = urlsplit(url).hostname or ""
        try:
            # To read the system's authorities takes a while; a plain address, of this machine
            # alone, needs none.
            secure = url.startswith("https:")
            verify = ssl.create_default_context(cafile=settings.ca or None) if secure else False
            status, body = await ask_address(
                url,
                lambda client: self._make_request(client, url, form, by_post=by_post),
                verify=verify,
                timeout_s=_TIMEOUT_S,
                most=_MOST_ANSWER,
            )
            said = json.loads(body)
        except EndlessAnswer as error:
            raise ProviderRefused(f"{host} answers without end") from error
        except (OSError, ValueError, RecursionError) as error:
            raise ProviderRefused(f"the provider {host} does not answer as one: {error}") from error
        if status != 200 or not isinstance(said, dict):
            reason = said.get("error", "") if isinstance(said, dict) else ""
            raise ProviderRefused(f"the provider {host} refuses ({status}): {str(reason)[:100]}")
        return said

    def _make_request(
        self,
        client: httpx.AsyncClient,
        url: str,
        form: dict[str, str] | None,
        *,
        by_post: bool,
    ) -> httpx.Request:
        if form is None:
            return client.build_request("GET", url)
        with Path(self.settings.client_secret_file).open("rb") as file:
            secret = file.read(_MOST_SECRET).decode("utf-8", "replace").strip()
        if by_post:
            more = {"client_id": self.settings.client_id, "client_secret": secret}
            return client.build_request("POST", url, data={**form, **more})
        request = client.build_request("POST", url, data=form)
        import httpx

        # Coded as in a form before it is packed (RFC 6749, 2.3.1).
        name, password = (urlencode({"": word})[1:] for word in (self.settings.client_id, secret))
        return next(httpx.BasicAuth(name, password).auth_flow(request))


def _check_address(name: str, value: object) -> None:
    found = urlsplit(value) if isinstance(value, str) else None
    secure = found is not None and found.scheme == "https"
    here = found is not None and found.scheme == "http" and is_loopback(found.hostname or "")
    if not (secure or here):
        raise ProviderRefused(f"the provider's {name} is no https address")
