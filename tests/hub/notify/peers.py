"""Servers on loopback that messages go to in tests: they keep what they are asked, and answer."""

# ruff: noqa: D107

from __future__ import annotations

import asyncio
import datetime as dt
import ipaddress
import ssl
from typing import TYPE_CHECKING

from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["Peer", "certified", "served"]


class Peer:
    """A web server that keeps what it is asked, and answers what it is told to."""

    def __init__(self) -> None:
        self.asked = []
        self.answer = "200 OK"
        self.headers = ""
        self.hangs_up = False
        self.news = asyncio.Queue()

    def answered(self, _line: str, _fields: dict[str, str], _body: bytes) -> tuple[str, str]:
        """Give the status and the JSON; a server that looks at what it is asked does so here."""
        return self.answer, "{}"

    async def serve(self, reader, writer) -> None:
        head = (await reader.readuntil(b"\r\n\r\n")).decode()
        lines = head.split("\r\n")
        named = (line.split(": ", 1) for line in lines[1:] if line)
        fields = {name.lower(): value for name, value in named}
        body = await reader.readexactly(int(fields.get("content-length", "0")))
        self.asked.append((lines[0], fields, body))
        self.news.put_nowait(self.asked[-1])
        status, text = self.answered(lines[0], fields, body)
        if not self.hangs_up:
            writer.write(
                f"HTTP/1.1 {status}\r\n{self.headers}Content-Type: application/json\r\n"
                f"Content-Length: {len(text)}\r\nConnection: close\r\n\r\n{text}".encode()
            )
        writer.close()


async def served(host: str, peer: Peer | None = None, tls: ssl.SSLContext | None = None):
    """Let a peer serve at a free port; give it and its server."""
    peer = peer or Peer()
    server = await asyncio.start_server(peer.serve, host, 0, ssl=tls)
    peer.port = server.sockets[0].getsockname()[1]
    return peer, server


def certified(folder: Path, *names: str) -> tuple[ssl.SSLContext, Path]:
    """Make a certificate for names and addresses; give a server's context, and what trusts it."""
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, names[0])])
    now = dt.datetime.now(dt.UTC)
    made = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - dt.timedelta(hours=1))
        .not_valid_after(now + dt.timedelta(hours=1))
        .add_extension(
            x509.SubjectAlternativeName([_named(each) for each in names]), critical=False
        )
        .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
        .sign(key, hashes.SHA256())
    )
    trusted, secret = folder / "peer.pem", folder / "peer-key.pem"
    trusted.write_bytes(made.public_bytes(Encoding.PEM))
    secret.write_bytes(key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()))
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(trusted, secret)
    return context, trusted


def _named(name: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(name))
    except ValueError:
        return x509.DNSName(name)
