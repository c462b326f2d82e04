"""Certificates for servers of tests on 127.0.0.1, and Python's own HTTP server with one."""

# ruff: noqa: D107
from __future__ import annotations

import datetime as dt
import ipaddress
import ssl

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID


class Certificates:
    """An authority, and a certificate of it for 127.0.0.1."""

    def __init__(self, folder) -> None:
        self.ca, self.cert, self.key = (folder / name for name in ("ca.pem", "c.pem", "k.pem"))
        ca_key, key = (ec.generate_private_key(ec.SECP256R1()) for _ in range(2))
        ca_name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "tests")])
        ca = self._certificate(ca_name, ca_name, ca_key.public_key(), ca_key, ca=True)
        name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "broker")])
        cert = self._certificate(name, ca_name, key.public_key(), ca_key, ca=False)
        pem = serialization.Encoding.PEM
        self.ca.write_bytes(ca.public_bytes(pem))
        self.cert.write_bytes(cert.public_bytes(pem))
        self.key.write_bytes(
            key.private_bytes(pem, serialization.PrivateFormat.PKCS8, serialization.NoEncryption())
        )

    def _certificate(self, name, issuer, public, signer, *, ca):
        now = dt.datetime.now(dt.UTC)
        return (
            x509.CertificateBuilder()
            .subject_name(name)
            .issuer_name(issuer)
            .public_key(public)
            .serial_number(x509.random_serial_number())
            .not_valid_before(now - dt.timedelta(days=1))
            .not_valid_after(now + dt.timedelta(days=1))
            .add_extension(x509.BasicConstraints(ca=ca, path_length=None), critical=True)
            .add_extension(
                x509.SubjectAlternativeName([x509.IPAddress(ipaddress.ip_address("127.0.0.1"))]),
                critical=False,
            )
            .sign(signer, hashes.SHA256())
        )


def speak_tls(server, certificates: Certificates) -> None:
    """Have an HTTP server of Python's speak TLS; a handshake that fails is its client's matter."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(certificates.cert, certificates.key)
    accept = server.get_request

    def get_request():
        line, address = accept()
        try:
            return context.wrap_socket(line, server_side=True), address
        except OSError:
            # It would be left to the garbage collector, which warns of it.
            line.close()
            raise

    server.get_request = get_request
