"""Bytes on a socket: what a browser would never say."""

from __future__ import annotations

import asyncio
from typing import NamedTuple

from patience import PATIENCE_S


class Reply(NamedTuple):
    """The first answer on a connection, and whether the hub closed it after."""

    status: int
    headers: dict[str, str]
    body: bytes


async def say(port: int, *parts: bytes, tls=None) -> Reply:
    """Send bytes over a connection of their own, and read one answer."""
    reader, writer = await asyncio.open_connection("127.0.0.1", port, ssl=tls)
    try:
        async with asyncio.timeout(PATIENCE_S):
            for part in parts:
                writer.write(part)
                await writer.drain()
            return await read(reader)
    finally:
        writer.close()


async def read(reader: asyncio.StreamReader) -> Reply:
    """Read one answer; the status is 0 when the connection was closed without one."""
    try:
        head = (await reader.readuntil(b"\r\n\r\n")).decode("latin-1").split("\r\n")
    except (asyncio.IncompleteReadError, ConnectionResetError):
        return Reply(0, {}, b"")
    status = int(head[0].split()[1])
    headers = {
        name.lower(): value.strip()
        for name, _, value in (line.partition(":") for line in head[1:] if line)
    }
    length = int(headers.get("content-length", 0))
    return Reply(status, headers, await reader.readexactly(length) if length else b"")


def request(path: str = "/api/health", *headers: str, method: str = "GET", host: str) -> bytes:
    """Write a request's head."""
    return "\r\n".join([f"{method} {path} HTTP/1.1", f"Host: {host}", *headers, "", ""]).encode()
