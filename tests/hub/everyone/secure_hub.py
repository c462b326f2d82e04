"""A hub that speaks TLS with a certificate of its own, and clients that know it."""

from __future__ import annotations

import ssl
from contextlib import asynccontextmanager
from dataclasses import replace

import httpx

PASSWORD = "a password for tests"  # noqa: S105


@asynccontextmanager
async def secure(hub_that_stores, settings, *, again=False, **changes):
    """Start a hub on TLS with a person for each role, and a key for the vehicle's gateway.

    With ``again`` they are there, from an earlier start on the same data folder.
    """
    running = hub_that_stores()
    running.settings = replace(settings, plain=False, **changes)
    running.__init__(running.settings, None)
    async with running:
        running.origin = f"https://127.0.0.1:{running.port}"
        if not again:
            await running.populate()
        yield running


def trusting(running) -> ssl.SSLContext:
    return ssl.create_default_context(cafile=str(running.settings.data / "tls" / "cert.pem"))


@asynccontextmanager
async def browsing(running, name: str = ""):
    """Open an HTTP client that trusts this hub, signed in as ``name`` unless it is empty."""
    headers = {"Origin": running.origin}
    async with httpx.AsyncClient(
        base_url=running.origin, headers=headers, verify=trusting(running), trust_env=False
    ) as client:
        if name:
            answer = await client.post("/api/login", json={"name": name, "password": PASSWORD})
            assert answer.status_code == 200, answer.text
        yield client
