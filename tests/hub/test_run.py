"""``talaia hub`` as a process: what it says, how it ends, what it refuses."""

import asyncio
import datetime as dt
import signal
import socket
import ssl
import stat

import httpx
import pytest
from async_program import AsyncProgram, start_program
from cryptography import x509
from patience import PATIENCE_S

from talaia.hub.certificate import certificate_fingerprint, own_certificate
from talaia.hub.errors import CannotStart
from talaia.hub.settings import Settings

NOW = dt.datetime(2030, 1, 1, tzinfo=dt.UTC)


async def started(*words: str) -> AsyncProgram | asyncio.subprocess.Process:
    return await start_program("-m", "talaia", "hub", *words, with_errors=True)


async def refused(*words: str) -> str:
    process = await started(*words)
    _, errors = await asyncio.wait_for(process.communicate(), PATIENCE_S)
    assert process.returncode == 2
    return errors.decode()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
async def test_hub_says_where_it_is_and_ends_cleanly(tmp_path, number) -> None:
    process = await started("--data", str(tmp_path / "data"), "--port", "0")
    assert process.stdout is not None
    ready = (await asyncio.wait_for(process.stdout.readline(), PATIENCE_S)).decode()
    print_ = (await process.stdout.readline()).decode()
    setup = (await process.stdout.readline()).decode()
    address = ready.split()[-1]
    assert ready.startswith("talaia hub is ready: https://localhost:")
    assert certificate_fingerprint(tmp_path / "data" / "tls" / "cert.pem") in print_
    assert f"{address}/setup#" in setup
    trust = ssl.create_default_context(cafile=str(tmp_path / "data" / "tls" / "cert.pem"))
    async with httpx.AsyncClient(verify=trust, trust_env=False) as client:
        answer = await client.get(f"{address}/api/health")
    assert "max-age=31536000" in answer.headers["strict-transport-security"]
    assert "server" not in answer.headers
    made = [path for path in (tmp_path / "data").rglob("*") if not path.is_symlink()]
    open_to_others = [path.name for path in made if path.stat().st_mode & 0o077]
    assert made
    assert open_to_others == []
    process.send_signal(number)
    assert await asyncio.wait_for(process.wait(), PATIENCE_S) == 0
    await process.communicate()


async def test_taken_port_is_named(tmp_path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        said = await refused("--data", str(tmp_path), "--plain", "--port", str(port))
    assert f"talaia hub: cannot listen on 127.0.0.1:{port}: " in said
    assert "--port" in said


async def test_plain_text_is_for_loopback_only(tmp_path) -> None:
    said = await refused("--data", str(tmp_path), "--plain", "--host", "0.0.0.0")  # noqa: S104
    assert "--plain would send passwords over the network" in said


async def test_data_folder_that_cannot_be_made_is_named(tmp_path) -> None:
    (tmp_path / "file").touch()
    said = await refused("--data", str(tmp_path / "file" / "data"), "--plain")
    assert "the data folder" in said


def test_certificate_of_our_own_covers_every_name_of_this_hub(tmp_path) -> None:
    own = own_certificate(Settings(data=tmp_path, hosts=("hub.example",)), NOW)
    found = x509.load_pem_x509_certificate(own.cert.read_bytes())
    names = found.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    said = {str(each.value) for each in names}
    assert {"localhost", "127.0.0.1", "::1", socket.gethostname().lower(), "hub.example"} <= said
    assert stat.S_IMODE(own.key.stat().st_mode) == 0o600
    assert stat.S_IMODE(own.key.parent.stat().st_mode) == 0o700


def test_certificate_is_kept_until_a_month_before_its_end(tmp_path) -> None:
    settings = Settings(data=tmp_path)
    first = certificate_fingerprint(own_certificate(settings, NOW).cert)
    assert (
        certificate_fingerprint(own_certificate(settings, NOW + dt.timedelta(days=790)).cert)
        == first
    )
    assert (
        certificate_fingerprint(own_certificate(settings, NOW + dt.timedelta(days=800)).cert)
        != first
    )


def test_certificate_without_its_key_is_refused(tmp_path) -> None:
    with pytest.raises(CannotStart, match="both --tls-cert and --tls-key"):
        own_certificate(Settings(data=tmp_path, cert=tmp_path / "cert.pem"), NOW)
