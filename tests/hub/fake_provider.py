"""A provider of sign-ins (OpenID Connect) that tells the truth, or lies as a test wants it to."""

from __future__ import annotations

import asyncio
import base64
import hashlib
import json
import secrets
import time
from contextlib import asynccontextmanager
from urllib.parse import parse_qs, urlsplit

from joserfc import jwt
from joserfc.jwk import RSAKey
from starlette.applications import Starlette
from starlette.responses import JSONResponse
from starlette.routing import Route

from talaia.bounded_http import serve_bounded

CLIENT, SECRET = "talaia", "a secret: of tests"
# One for all tests: making a key takes longer than a test.
KEY = RSAKey.generate_key(2048, {"use": "sig", "alg": "RS256", "kid": "one"})
ANOTHER_KEY = RSAKey.generate_key(2048, {"use": "sig", "alg": "RS256", "kid": "one"})


class FakeProvider:
    """Signs in whom a test names, and says what a test makes of it.

    ``claims`` are those of the person; ``lies`` change the token last.
    """

    def __init__(self) -> None:  # noqa: D107
        self.issuer = ""
        self.claims = {"sub": "1", "preferred_username": "ada", "groups": ["pilots"]}
        self.lies = {}
        self.key = KEY
        self.algorithm = "RS256"
        self.discovery = {}
        self._codes = {}

    def sign_in(self, url: str) -> dict[str, str]:
        """Do what a browser and its person do there; give what it comes back with."""
        asked = {name: values[0] for name, values in parse_qs(urlsplit(url).query).items()}
        code = secrets.token_urlsafe(16)
        self._codes[code] = asked
        return {"state": asked["state"], "code": code}

    async def configuration(self, _request) -> JSONResponse:
        return JSONResponse(
            {
                "issuer": self.issuer,
                "authorization_endpoint": f"{self.issuer}/authorize",
                "token_endpoint": f"{self.issuer}/token",
                "jwks_uri": f"{self.issuer}/keys",
                **self.discovery,
            }
        )

    async def keys(self, _request) -> JSONResponse:
        return JSONResponse({"keys": [KEY.as_dict(private=False)]})

    async def token(self, request) -> JSONResponse:
        form = {
            name: values[0] for name, values in parse_qs((await request.body()).decode()).items()
        }
        asked = self._codes.pop(form["code"], None)
        packed = base64.b64encode(f"{CLIENT}:a+secret%3A+of+tests".encode()).decode()
        digest = hashlib.sha256(form["code_verifier"].encode()).digest()
        challenge = base64.urlsafe_b64encode(digest).rstrip(b"=").decode()
        if (
            asked is None
            or request.headers["authorization"] != f"Basic {packed}"
            or asked["redirect_uri"] != form["redirect_uri"]
            or asked["code_challenge"] != challenge
        ):
            return JSONResponse({"error": "invalid_grant"}, 400)
        return JSONResponse({"id_token": self.make_token(asked["nonce"])})

    def make_token(self, nonce: str) -> str:
        now_s = int(time.time())
        said = {
            "iss": self.issuer,
            "aud": CLIENT,
            "iat": now_s,
            "exp": now_s + 300,
            "auth_time": now_s,
            "nonce": nonce,
            **self.claims,
            **self.lies,
        }
        kept = {name: value for name, value in said.items() if value is not None}
        if self.algorithm == "none":
            return f"{_pack({'alg': 'none'})}.{_pack(kept)}."
        return jwt.encode({"alg": self.algorithm, "kid": "one"}, kept, self.key)


def _pack(said: dict) -> str:
    return base64.urlsafe_b64encode(json.dumps(said).encode()).rstrip(b"=").decode()


@asynccontextmanager
async def serve_provider():
    provider = FakeProvider()
    application = Starlette(
        routes=[
            Route("/.well-known/openid-configuration", provider.configuration),
            Route("/keys", provider.keys),
            Route("/token", provider.token, methods=["POST"]),
        ]
    )
    async with serve_bounded(application, "127.0.0.1", 0, most_connections=20) as port:
        provider.issuer = f"http://127.0.0.1:{port}"
        yield provider
    # What was let go of is closed by the loop's next turn, which may be its last.
    for _ in range(2):
        await asyncio.sleep(0)
