"""``talaia gateway enrol``: from the code on the page to a link, with a real hub on TLS."""

from __future__ import annotations

import asyncio
import json
import socket
import stat

import pytest
from async_program import AsyncProgram, start_program
from patience import PATIENCE_S

from talaia.gateway.command_line import parse_arguments, settings_of
from talaia.gateway.enrolment import enrol_gateway
from talaia.gateway.errors import EnrolRefused, HubUnreachable, LinkLost, SettingsError
from talaia.gateway.key_file import KeyFile, KeyPlace, read_key_file
from talaia.gateway.uplink.tls import HubTrust
from talaia.model.yaml_text.load import load_site
from talaia.wire.enrolment import EnrolmentCode, pin_of, secret_of

from ...everyone.secure_hub import browsing, secure

SITE = "talaia: 1\nsite: agv\nname: A\ndevices: {d: {name: D}}\n"


async def run(*words: str) -> tuple[int, str, str]:
    process = await started(*words)
    out, err = await asyncio.wait_for(process.communicate(), PATIENCE_S)
    return process.returncode or 0, out.decode(), err.decode()


async def started(*words: str) -> AsyncProgram | asyncio.subprocess.Process:
    return await start_program("-m", "talaia", "gateway", *words, with_errors=True)


async def code_of(running) -> dict:
    async with browsing(running, "admin") as admin:
        answer = await admin.post("/api/gateways/codes", json={"site": "agv"})
        return answer.json()


def enrolled(url: str, code: str, **more) -> asyncio.Future:
    """Enrol in a thread: the hub runs in this very loop."""
    return asyncio.to_thread(enrol_gateway, url, text=code, name="rover", **more)


async def test_code_from_the_page_makes_a_gateway_that_links_without_more_words(
    hub_that_stores, settings, tmp_path
) -> None:
    key_file, site = tmp_path / "agv.key", tmp_path / "site.yaml"
    site.write_text(SITE)
    async with secure(hub_that_stores, settings) as running:
        made = await code_of(running)
        words = made["command"].split()[2:]
        words[words.index("--key-file") + 1] = str(key_file)
        code, said, problems = await run(*words)
        assert (code, problems) == (0, "")
        assert "the hub is known by its key" in said
        assert stat.S_IMODE(key_file.stat().st_mode) == 0o600
        kept = read_key_file(key_file)
        assert (kept.site, kept.hub) == ("agv", f"wss://127.0.0.1:{running.port}")
        assert [each.name for each in tmp_path.iterdir() if each.name.startswith(".")] == []

        process = await started(
            str(site), "--key-file", str(key_file), "--data", str(tmp_path / "gateway")
        )
        try:
            async with browsing(running, "admin") as admin, asyncio.timeout(PATIENCE_S):
                while True:
                    listed = (await admin.get("/api/gateways")).json()["gateways"]
                    mine = next(each for each in listed if each["id"] == kept.gateway)
                    if mine["online"]:
                        break
                    await asyncio.sleep(0.1)
            assert mine["version"]
        finally:
            process.terminate()
            await process.communicate()


async def test_hub_that_shows_another_key_is_not_told_the_code(hub_that_stores, settings) -> None:
    async with secure(hub_that_stores, settings) as running:
        code = EnrolmentCode(secret_of(7), pin_of("00" * 32))
        with pytest.raises(HubUnreachable, match="was not told the code"):
            await enrolled(running.origin, str(code))
        async with browsing(running, "admin") as admin:
            rows = (await admin.get("/api/audit?kind=gateway")).json()["rows"]
        assert rows == []


async def test_without_the_hubs_key_in_the_code_an_authority_must_vouch_for_it(
    hub_that_stores, settings
) -> None:
    async with secure(hub_that_stores, settings) as running:
        secret = (await code_of(running))["code"].replace("-", "")[:12]
        short = str(EnrolmentCode(secret))
        with pytest.raises(HubUnreachable, match=r"cannot be trusted: .*copy the whole code"):
            await enrolled(running.origin, short)
        ca = running.settings.data / "tls" / "cert.pem"
        kept = await enrolled(running.origin, short, ca=ca)
        assert (kept.fingerprint, kept.ca) == ("", str(ca))


async def test_refusals_of_the_hub_reach_the_person(hub_that_stores, settings) -> None:
    async with secure(hub_that_stores, settings) as running:
        made = await code_of(running)
        await enrolled(running.origin, made["code"])
        with pytest.raises(EnrolRefused, match="used already; make a new one"):
            await enrolled(running.origin, made["code"])


async def test_hub_that_is_not_there_or_is_no_hub_is_said_so(tmp_path) -> None:
    code = str(EnrolmentCode(secret_of(7), pin_of("00" * 32)))
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    with pytest.raises(LinkLost, match="cannot be reached"):
        await enrolled(f"https://127.0.0.1:{port}", code)

    async def answer(reader, writer) -> None:
        await reader.readuntil(b"\r\n\r\n")
        writer.write(b"HTTP/1.1 200 OK\r\nContent-Length: 5\r\nConnection: close\r\n\r\nhello")
        writer.close()

    async with await asyncio.start_server(answer, "127.0.0.1", 0) as server:
        port = server.sockets[0].getsockname()[1]
        with pytest.raises(EnrolRefused, match="is it a Talaia hub"):
            await enrolled(f"http://127.0.0.1:{port}", code, allow_plain=True)


async def test_clear_text_is_refused_but_for_loopback_on_request(hub) -> None:
    code = str(EnrolmentCode(secret_of(7)))
    with pytest.raises(SettingsError, match="--allow-plain on loopback"):
        await enrolled(hub.origin, code)
    with pytest.raises(SettingsError, match="plain text is for loopback only"):
        await enrolled("http://192.0.2.1:8443", code, allow_plain=True)
    admin = await hub.client("admin")
    made = (await admin.post("/api/gateways/codes", json={"site": "agv"})).json()
    kept = await enrolled(hub.origin, made["code"], allow_plain=True)
    assert kept.hub == f"ws://127.0.0.1:{hub.port}"


async def test_mistyped_code_is_seen_before_anybody_is_asked(tmp_path) -> None:
    code, said, problems = await run(
        "enrol", "https://192.0.2.1:1", "ABCDE-12345", "--key-file", str(tmp_path / "k")
    )
    assert (code, said) == (2, "")
    assert problems.startswith("talaia gateway enrol: the code was mistyped: it has 10 letters")
    assert list(tmp_path.iterdir()) == []


# ── the key file ──


def test_key_is_kept_by_its_owner_only_and_read_back(tmp_path) -> None:
    path, kept = tmp_path / "agv.key", KeyFile(key="k" * 43, site="agv", hub="wss://h:1")
    place = KeyPlace(path)
    place.save_key(kept)
    place.close()
    assert read_key_file(path) == kept
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert "k" * 43 not in repr(kept)


def test_plain_key_file_of_before_is_still_read(tmp_path) -> None:
    path = tmp_path / "key"
    path.write_text("secret-key\n")
    assert read_key_file(path) == KeyFile(key="secret-key")


@pytest.mark.parametrize(
    "content", ["", "two words", "{", "{}", '{"key": 1}', '{"key": ""}', '{"key": "a\\nb"}', "é"]
)
def test_file_without_a_key_is_refused(tmp_path, content) -> None:
    path = tmp_path / "key"
    path.write_text(content)
    with pytest.raises(SettingsError, match="--key-file"):
        read_key_file(path)


def test_other_file_is_not_overwritten_and_the_code_not_used(tmp_path) -> None:
    path = tmp_path / "site.yaml"
    path.write_text(SITE)
    with pytest.raises(SettingsError, match="holds no gateway's key; choose another"):
        KeyPlace(path)
    assert path.read_text() == SITE
    with pytest.raises(SettingsError, match="cannot be written"):
        KeyPlace(tmp_path / "missing" / "agv.key")


def settings_from(tmp_path, *words: str):
    return settings_of(parse_arguments(["site.yaml", *words])[0], load_site(SITE))


def test_key_file_says_where_the_hub_is_and_words_win_over_it(tmp_path) -> None:
    path = tmp_path / "agv.key"
    path.write_text(
        json.dumps({"key": "k", "site": "agv", "hub": "wss://h:1", "fingerprint": "5f" * 32})
    )
    words = ("--key-file", str(path))
    kept = settings_from(tmp_path, *words)
    assert (kept.hub.url, kept.hub.fingerprint) == ("wss://h:1", "5f" * 32)
    moved = settings_from(tmp_path, *words, "--hub", "wss://other:2")
    assert (moved.hub.url, moved.hub.fingerprint) == ("wss://other:2", "5f" * 32)
    other = settings_from(tmp_path, *words, "--fingerprint", "AA:" * 31 + "AA")
    assert other.hub.fingerprint == "aa" * 32


def test_key_of_another_site_and_a_hub_that_is_nowhere_said_are_refused(tmp_path) -> None:
    path = tmp_path / "key"
    path.write_text(json.dumps({"key": "k", "site": "moon", "hub": "wss://h:1"}))
    with pytest.raises(SettingsError, match="is for the site 'moon'"):
        settings_from(tmp_path, "--key-file", str(path))
    path.write_text("plain-key")
    with pytest.raises(SettingsError, match="give --hub"):
        settings_from(tmp_path, "--key-file", str(path))


async def test_gateway_refuses_a_hub_whose_key_has_changed(hub_that_stores, settings) -> None:
    async with secure(hub_that_stores, settings) as running:
        kept = await enrolled(running.origin, (await code_of(running))["code"])
    (running.settings.data / "tls" / "key.pem").unlink()
    async with secure(hub_that_stores, settings, again=True) as running:
        hub = settings_of_hub(kept, running.port)
        with pytest.raises(LinkLost, match=r"not the one that this gateway knows.*enrol"):
            await HubTrust(hub).context()


def settings_of_hub(kept: KeyFile, port: int):
    from talaia.gateway.settings import HubAddress

    return HubAddress.from_text(f"wss://127.0.0.1:{port}", fingerprint=kept.fingerprint)
