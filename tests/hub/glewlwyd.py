"""A real provider of sign-ins that we did not write: Debian's Glewlwyd, with one person in it."""

from __future__ import annotations

import asyncio
import os
import re
import shutil
import socket
import sqlite3
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import httpx
import pytest
from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric import rsa
from patience import ASK_S, PATIENCE_S
from shared_trust import usual_trust

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

_PROGRAM = "glewlwyd"
_CONFIGURATION = Path("/etc/glewlwyd/glewlwyd.conf")
_TABLES = Path("/usr/share/dbconfig-common/data/glewlwyd/install/sqlite3")
# It does not decode what it is sent (RFC 6749, 2.3.1): letters that stay as they are.
CLIENT, SECRET = "talaia", "secret-of-tests"
PASSWORD = "ada's own password"  # noqa: S105


class Glewlwyd:
    """The provider, set up by its own interface for administrators."""

    def __init__(self, port: int) -> None:  # noqa: D107
        self.origin = f"http://127.0.0.1:{port}"
        self.issuer = f"{self.origin}/api/oidc"

    async def set_up(self, redirect: str) -> None:
        """Add a plug-in for OpenID Connect, a client, and a person."""
        async with httpx.AsyncClient(
            base_url=f"{self.origin}/api", trust_env=False, verify=usual_trust()
        ) as client:
            await self._wait(client)
            # The password that the package comes with.
            await _do(client, "POST", "/auth", {"username": "admin", "password": "password"})
            module = (await client.get("/mod/user/database")).json()
            shown = {"read": True, "write": True}
            module["parameters"]["data-format"] |= {
                "groups": {"multiple": True, **shown},
                "verified": {"multiple": False, **shown},
            }
            await _do(client, "PUT", "/mod/user/database", module)
            await _do(client, "PUT", "/mod/user/database/reset/", {})
            # With a scope that asks for the password, the token says when it was given.
            scope = {"name": "openid", "password_required": True, "password_max_age": 0}
            await _do(client, "PUT", "/scope/openid", {**scope, "scheme": {}})
            plugin = {"module": "oidc", "name": "oidc", "display_name": "oidc", "order_rank": 0}
            await _do(client, "POST", "/mod/plugin/", {**plugin, "parameters": self._parameters()})
            await _do(
                client,
                "POST",
                "/client/",
                {
                    "client_id": CLIENT,
                    "name": "Talaia",
                    "password": SECRET,
                    "client_secret": SECRET,
                    "confidential": True,
                    "enabled": True,
                    "scope": [],
                    "redirect_uri": [redirect],
                    "authorization_type": ["code"],
                    "token_endpoint_auth_method": ["client_secret_basic"],
                },
            )
            person = {
                "username": "ada",
                "password": PASSWORD,
                "name": "Ada",
                "email": "ada@uni.example",
                "enabled": True,
                "scope": ["openid", "g_profile"],
                "groups": ["staff", "chiefs"],
                "verified": "yes",
            }
            await _do(client, "POST", "/user/", person)
        async with httpx.AsyncClient(
            base_url=f"{self.origin}/api", trust_env=False, verify=usual_trust()
        ) as person:
            await _do(person, "POST", "/auth", {"username": "ada", "password": PASSWORD})
            # That the client may know who she is she has said before.
            await _do(person, "PUT", f"/auth/grant/{CLIENT}/", {"scope": "openid"})

    async def _wait(self, client: httpx.AsyncClient) -> None:
        async with asyncio.timeout(PATIENCE_S):
            while True:
                try:
                    await client.get("/auth")
                except httpx.TransportError:
                    await asyncio.sleep(ASK_S)
                else:
                    return

    def _parameters(self) -> dict[str, object]:
        key = rsa.generate_private_key(65537, 2048)
        pem = serialization.Encoding.PEM
        private = key.private_bytes(
            pem, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
        )
        public = key.public_key().public_bytes(pem, serialization.PublicFormat.SubjectPublicKeyInfo)
        off = ("token", "none", "password", "client", "device", "refresh")
        claim = {"mandatory": True, "scope": []}
        return {
            "iss": self.issuer,
            "jwt-type": "rsa",
            "jwt-key-size": "256",
            "key": private.decode(),
            "cert": public.decode(),
            "access-token-duration": 3600,
            "refresh-token-duration": 3600,
            "code-duration": 600,
            "refresh-token-rolling": False,
            "allow-non-oidc": False,
            "auth-type-code-enabled": True,
            "auth-type-code-revoke-replayed": True,
            "auth-type-id-token-enabled": True,
            **{f"auth-type-{each}-enabled": False for each in off},
            "subject-type": "public",
            "jwks-show": True,
            "pkce-allowed": True,
            "pkce-method-plain-allowed": False,
            "pkce-required": True,
            "oauth-par-allowed": False,
            "request-parameter-allow": False,
            "encrypt-out-token-allow": False,
            "allowed-scope": ["openid"],
            "scope": [],
            "email-claim": "mandatory",
            "name-claim": "mandatory",
            "claims": [
                {"name": "groups", "user-property": "groups", "type": "string", **claim},
                {
                    "name": "preferred_username",
                    "user-property": "username",
                    "type": "string",
                    **claim,
                },
                {
                    "name": "email_verified",
                    "user-property": "verified",
                    "type": "boolean",
                    "boolean-value-true": "yes",
                    "boolean-value-false": "no",
                    **claim,
                },
            ],
        }


@asynccontextmanager
async def run_glewlwyd(folder: Path) -> AsyncIterator[Glewlwyd]:
    """Run one with a database of its own."""
    program = shutil.which(_PROGRAM)
    if program is None or not _TABLES.is_file():  # noqa: ASYNC240 - as good as nothing
        (pytest.fail if os.environ.get("TALAIA_REQUIRE_ALL") else pytest.skip)("no Glewlwyd")
    with sqlite3.connect(folder / "glewlwyd.db") as database:
        database.executescript(_TABLES.read_text())  # noqa: ASYNC240 - as above
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    file = folder / "glewlwyd.conf"
    file.write_text(_configuration(folder, port))
    log = (folder / "glewlwyd.log").open("wb")
    process = await asyncio.create_subprocess_exec(
        program, f"--config-file={file}", stdout=log, stderr=log
    )
    try:
        yield Glewlwyd(port)
    finally:
        process.terminate()
        await process.wait()
        log.close()


def _configuration(folder: Path, port: int) -> str:
    """Change the package's own."""
    text = _CONFIGURATION.read_text()
    changed = {
        "port": port,
        "bind_address": '"127.0.0.1"',
        # It writes a stroke of its own behind it.
        "external_url": f'"http://127.0.0.1:{port}"',
        "log_mode": '"console"',
        "static_files_path": '"/usr/share/glewlwyd/webapp/"',
    }
    for name in changed:
        text = re.sub(rf"(?m)^#?\s*{name}\s*=.*$", "", text)
    text = re.sub(r"(?m)^@include.*glewlwyd-db.conf.*$", "", text)
    lines = "".join(f"{name} = {value}\n" for name, value in changed.items())
    return f'{lines}database = {{ type = "sqlite3" path = "{folder}/glewlwyd.db" }};\n{text}'


async def _do(client: httpx.AsyncClient, method: str, path: str, said: object) -> None:
    answer = await client.request(method, path, json=said)
    assert answer.status_code == 200, (path, answer.status_code, answer.text)
