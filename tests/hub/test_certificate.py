"""The hub's certificate: given or its own, checked at the start, renewed while it runs."""

from __future__ import annotations

import asyncio
import datetime as dt
import hashlib
import logging
import socket
import ssl
import stat
from concurrent.futures import ThreadPoolExecutor

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

from talaia.hub.certificate import (
    certificate_fingerprint,
    fresh_certificate,
    key_hash,
    own_certificate,
)
from talaia.hub.errors import CannotStart
from talaia.hub.run import renew_certificate
from talaia.hub.settings import Settings
from talaia.wire.certificate_der import public_key_of

from .everyone.secure_hub import secure

NOW = dt.datetime(2030, 1, 1, tzinfo=dt.UTC)
DAY = dt.timedelta(days=1)


def made(folder, *, name="given", key=None, begins=NOW - DAY, ends=NOW + 90 * DAY, secret=None):
    """Write a certificate and its key, as an authority's tool would."""
    key = key or ec.generate_private_key(ec.SECP256R1())
    subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])
    cert = (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(subject)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(begins)
        .not_valid_after(ends)
        .sign(key, hashes.SHA256())
    )
    paths = folder / f"{name}.pem", folder / f"{name}.key"
    paths[0].write_bytes(cert.public_bytes(serialization.Encoding.PEM))
    paths[1].write_bytes(
        key.private_bytes(
            serialization.Encoding.PEM,
            serialization.PrivateFormat.PKCS8,
            serialization.BestAvailableEncryption(secret) if secret else NO_SECRET,
        )
    )
    paths[1].chmod(0o600)
    return paths


NO_SECRET = serialization.NoEncryption()


def given(tmp_path, cert, key) -> Settings:
    return Settings(data=tmp_path, cert=cert, key=key)


def test_given_certificate_is_used_as_it_is(tmp_path) -> None:
    cert, key = made(tmp_path)
    assert own_certificate(given(tmp_path, cert, key), NOW) == (cert, key)
    assert not (tmp_path / "tls").exists()


def test_key_of_another_certificate_is_refused_by_name(tmp_path) -> None:
    cert, _ = made(tmp_path, name="one")
    _, key = made(tmp_path, name="two")
    with pytest.raises(
        CannotStart, match=r"two\.key is not that of the first certificate in .*one"
    ):
        own_certificate(given(tmp_path, cert, key), NOW)


def test_locked_key_is_refused_with_the_way_to_open_it(tmp_path) -> None:
    cert, key = made(tmp_path, secret=b"locked")
    with pytest.raises(CannotStart, match="locked by a passphrase; give one without: openssl"):
        own_certificate(given(tmp_path, cert, key), NOW)


@pytest.mark.parametrize(
    ("begins", "ends", "said"),
    [
        (NOW - 99 * DAY, NOW - DAY, "ended on 2029-12-31; renew it"),
        (NOW + DAY, NOW + 9 * DAY, "begins on 2030-01-02; set this machine's clock"),
    ],
)
def test_certificate_out_of_its_time_is_refused(tmp_path, begins, ends, said) -> None:
    cert, key = made(tmp_path, begins=begins, ends=ends)
    with pytest.raises(CannotStart, match=said):
        own_certificate(given(tmp_path, cert, key), NOW)


def test_file_that_is_missing_or_something_else_is_named(tmp_path) -> None:
    cert, key = made(tmp_path)
    (tmp_path / "text").write_text("hello")
    for wrong_cert, wrong_key, said in (
        (tmp_path / "none", key, "none cannot be read: No such file"),
        (cert, tmp_path / "none", "none cannot be read: No such file"),
        (tmp_path / "text", key, "text holds no PEM certificate"),
        (cert, tmp_path / "text", "text holds no private key"),
        (key, cert, "given.key holds no PEM certificate"),
    ):
        with pytest.raises(CannotStart, match=said):
            own_certificate(given(tmp_path, wrong_cert, wrong_key), NOW)


def test_key_that_others_can_read_is_warned_of(tmp_path, caplog) -> None:
    cert, key = made(tmp_path)
    key.chmod(0o644)
    with caplog.at_level(logging.WARNING):
        own_certificate(given(tmp_path, cert, key), NOW)
    assert f"chmod 600 {key}" in caplog.text


def test_own_key_gets_its_rights_back(tmp_path) -> None:
    settings = Settings(data=tmp_path)
    own = own_certificate(settings, NOW)
    own.key.chmod(0o644)
    own.key.parent.chmod(0o755)
    own_certificate(settings, NOW)
    assert stat.S_IMODE(own.key.stat().st_mode) == 0o600
    assert stat.S_IMODE(own.key.parent.stat().st_mode) == 0o700


def test_renewal_and_another_name_keep_the_key_that_gateways_know(tmp_path) -> None:
    own = own_certificate(Settings(data=tmp_path), NOW)
    before, key = certificate_fingerprint(own.cert), key_hash(own.cert)
    own_certificate(Settings(data=tmp_path), NOW + 800 * DAY)
    assert certificate_fingerprint(own.cert) != before
    assert key_hash(own.cert) == key
    own_certificate(Settings(data=tmp_path, hosts=("hub.example",)), NOW + 800 * DAY)
    assert key_hash(own.cert) == key


def test_own_certificate_that_is_broken_is_made_anew(tmp_path) -> None:
    settings = Settings(data=tmp_path)
    own = own_certificate(settings, NOW)
    key = key_hash(own.cert)
    own.cert.write_text("-----BEGIN CERTIFICATE-----\nx\n-----END CERTIFICATE-----\n")
    own_certificate(settings, NOW)
    assert key_hash(own.cert) == key
    own.key.write_text("no key")
    own_certificate(settings, NOW)
    assert key_hash(own.cert) != key
    ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_cert_chain(own.cert, own.key)


def test_certificate_that_did_not_change_is_not_loaded_again(tmp_path) -> None:
    settings = Settings(data=tmp_path)
    shown = certificate_fingerprint(own_certificate(settings, NOW).cert)
    assert fresh_certificate(settings, NOW, shown) is None
    found = fresh_certificate(settings, NOW + 800 * DAY, shown)
    assert found is not None
    assert certificate_fingerprint(found.cert) != shown


def test_gateway_finds_the_same_public_key_in_a_certificate_as_the_hub(tmp_path) -> None:
    own = own_certificate(Settings(data=tmp_path), NOW)
    cert = x509.load_pem_x509_certificate(own.cert.read_bytes())
    der = cert.public_bytes(serialization.Encoding.DER)
    assert hashlib.sha256(public_key_of(der)).hexdigest() == key_hash(own.cert)
    for wrong in (b"", b"\x30", der[:-1], der[10:], b"\x30\x82\xff\xff", b"\x04" + der[1:]):
        with pytest.raises(ValueError, match="certificate"):
            public_key_of(wrong)


async def shown_by(port: int) -> str:
    looking = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    looking.check_hostname, looking.verify_mode = False, ssl.CERT_NONE
    _, writer = await asyncio.open_connection("127.0.0.1", port, ssl=looking)
    der = writer.get_extra_info("ssl_object").getpeercert(binary_form=True)
    writer.close()
    return der.hex()


async def test_renewed_certificate_is_shown_without_a_restart(
    hub_that_stores, settings, tmp_path, caplog
) -> None:
    now = dt.datetime.now(dt.UTC)
    cert, key = made(tmp_path, begins=now - DAY, ends=now + DAY)
    async with secure(hub_that_stores, settings, cert=cert, key=key) as running:
        context, shown = running._server.config.ssl, certificate_fingerprint(cert)
        before = await shown_by(running.port)
        cert.write_text("half written")
        with caplog.at_level(logging.WARNING):
            assert await renew_certificate(context, running.settings, shown) == shown
        assert "the certificate of before stays" in caplog.text
        assert await shown_by(running.port) == before
        made(tmp_path, begins=now - DAY, ends=now + 90 * DAY)
        assert await renew_certificate(context, running.settings, shown) == certificate_fingerprint(
            cert
        )
        assert await shown_by(running.port) != before


def test_hubs_that_share_a_folder_agree_on_one_certificate_whatever_their_machines_are_called(
    tmp_path,
) -> None:
    def names_for(*hosts: str) -> tuple[str, set[str]]:
        settings = Settings(data=tmp_path, cluster=("nats://n",), hosts=hosts)
        found = own_certificate(settings, NOW).cert
        names = x509.load_pem_x509_certificate(found.read_bytes()).extensions
        shown = names.get_extension_for_class(x509.SubjectAlternativeName).value
        return certificate_fingerprint(found), set(shown.get_values_for_type(x509.DNSName))

    first, names = names_for("hub.example")
    assert "hub.example" in names
    # Each container has another one: with it they would make the certificate anew in turn.
    assert socket.gethostname().lower() not in names - {"localhost"}
    # A name that one alone has is added once, and the others keep to it.
    second, _names = names_for("hub.example", "other.example")
    assert second != first
    assert names_for("hub.example")[0] == second


def test_hubs_that_start_at_once_in_one_folder_have_one_key(tmp_path) -> None:
    settings = Settings(data=tmp_path, cluster=("nats://n",))
    with ThreadPoolExecutor(8) as pool:
        made = list(pool.map(lambda _: own_certificate(settings, NOW), range(8)))
    assert len({key_hash(each.cert) for each in made}) == 1
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(made[0].cert, made[0].key)
    assert {path.name for path in (tmp_path / "tls").iterdir()} == {"cert.pem", "key.pem"}
