"""The way to a network camera, with hosts and servers that want to lead elsewhere."""

from __future__ import annotations

import select
import socket
import ssl
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from patience import Stopwatch

from talaia.gateway.adapters.video.relay import (
    CameraRefused,
    CameraRelay,
    CameraResponseFilter,
    addresses_of,
)
from talaia.gateway.legacy.self_signed import self_signed


@pytest.mark.parametrize(
    ("host", "address"),
    [
        ("127.0.0.1", "127.0.0.1"),
        ("localhost", "this computer"),
        ("2130706433", "127.0.0.1"),
        ("0177.0.0.1", "127.0.0.1"),
        ("0x7f.1", "127.0.0.1"),
        ("0x7f000001", "127.0.0.1"),
        ("127.1", "127.0.0.1"),
        ("0", "0.0.0.0"),  # noqa: S104
        ("2852039166", "169.254.169.254"),
        ("0xa9.0xfe.0251.254", "169.254.169.254"),
        ("::ffff:127.0.0.1", "127.0.0.1"),
        ("fe80::1", "fe80::1"),
        ("224.0.0.251", "224.0.0.251"),
    ],
)
def test_however_an_address_is_spelled_it_is_the_number_that_is_checked(
    host: str, address: str
) -> None:
    with pytest.raises(CameraRefused) as refused:
        addresses_of(host, 554, here=False)
    assert address in str(refused.value)


def test_every_address_of_a_name_must_be_fine(monkeypatch: pytest.MonkeyPatch) -> None:
    def looked_up(_host: str, port: int, **_: object) -> list[object]:
        return [(2, 1, 6, "", ("192.168.1.20", port)), (2, 1, 6, "", ("169.254.169.254", port))]

    monkeypatch.setattr(socket, "getaddrinfo", looked_up)
    with pytest.raises(CameraRefused, match=r"camera\.test is 169\.254\.169\.254"):
        addresses_of("camera.test", 554, here=True)


def test_a_name_is_looked_up_once_and_what_was_checked_is_opened(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    answers, real = [["127.0.0.1"], ["169.254.169.254"]], socket.getaddrinfo

    def rebinding(host: str, port: int, *_: object, **more: object) -> list[object]:
        if host != "camera.test":
            return list(real(host, port, type=socket.SOCK_STREAM))
        return [(2, 1, 6, "", (each, port)) for each in answers.pop(0)]

    with socket.create_server(("127.0.0.1", 0)) as server:
        monkeypatch.setattr(socket, "getaddrinfo", rebinding)
        port = server.getsockname()[1]
        with CameraRelay(f"rtsp://camera.test:{port}/x?y=1", here=True, timeout=5) as relay:
            server.accept()[0].close()
            assert relay.url.startswith("rtsp://127.0.0.1:")
            assert relay.url.endswith("/x?y=1")
    assert answers == [["169.254.169.254"]]


@pytest.mark.parametrize(
    "answer",
    [
        b"RTSP/1.0 302 Moved\r\nLocation: rtsp://169.254.169.254/x\r\n\r\n",
        b"RTSP/1.0 200 OK\nCSeq: 1\n\nRTSP/1.0 301 Moved\r\nLocation: rtsp://10.0.0.1/\r\n\r\n",
        b"RTSP/1.0 200 OK\r\nContent-Length: 4\r\n\r\nbodyRTSP/1.0 305 Proxy\r\n\r\n",
        b"REDIRECT rtsp://10.0.0.1/ RTSP/1.0\r\nCSeq: 7\r\n\r\n",
        b"HTTP/1.1 302 Found\r\nLocation: http://169.254.169.254/\r\n\r\n",
        b"RTSP/1.0 200 OK\r\nContent-Length: 0\r\nContent-Length: 90\r\n\r\n",
        b"RTSP/1.0 200 OK\r\nContent-Length: -1\r\n\r\n",
        b"RTSP/1.0 200 OK\r\nContent-Length: 9999999\r\n\r\n",
        b"RTSP/1.0 200 OK\r\nTransport: RTP/AVP;source=1.2.3.4,RTP/AVP;a=b\r\n\r\n",
        b"\r\n\r\nRTSP/1.0 302 Moved\r\n\r\n",
        b"x" * 20_000,
    ],
)
@pytest.mark.parametrize("piece", [1, 100_000])
def test_an_answer_that_leads_elsewhere_is_not_passed_on(answer: bytes, piece: int) -> None:
    answers = CameraResponseFilter("192.168.1.20")
    passed: list[bytes] = []
    pieces = (answer[at : at + piece] for at in range(0, len(answer), piece))
    with pytest.raises(CameraRefused):
        passed.extend(map(answers.filter_bytes, pieces))
    assert b"RTSP/1.0 3" not in b"".join(passed)


def test_plain_answers_pass_whole_and_packets_go_only_to_the_camera() -> None:
    answers = CameraResponseFilter("192.168.1.20")
    assert answers.filter_bytes(b"RTSP/1.0 200 OK\r\nContent-Length: 3\r\n\r\nab") == b""
    assert answers.filter_bytes(b"c") == b"RTSP/1.0 200 OK\r\nContent-Length: 3\r\n\r\nabc"
    setup = b"RTSP/1.0 200 OK\nTransport: RTP/AVP;unicast;Source=10.0.0.1;server_port=1-2\n\n"
    assert answers.filter_bytes(setup) == (
        b"RTSP/1.0 200 OK\r\nTransport: RTP/AVP;unicast;server_port=1-2;source=192.168.1.20\r\n\r\n"
    )


@contextmanager
def redirecting(to: int) -> Iterator[int]:
    """Serve an RTSP server that sends its client on to another port of this computer."""

    def serve() -> None:
        while True:
            try:
                client, _ = door.accept()
            except OSError:
                return
            with client:
                client.recv(4096)
                client.sendall(
                    f"RTSP/1.0 302 Moved\r\nCSeq: 1\r\nLocation: rtsp://127.0.0.1:{to}/\r\n\r\n".encode()
                )
                client.recv(4096)

    with socket.create_server(("127.0.0.1", 0)) as door:
        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        yield door.getsockname()[1]
        door.shutdown(socket.SHUT_RDWR)
        thread.join(5)


def test_the_codec_follows_no_redirect() -> None:
    av = pytest.importorskip("av")
    with socket.create_server(("127.0.0.1", 0)) as other:
        other.settimeout(0)
        with (
            redirecting(other.getsockname()[1]) as port,
            CameraRelay(f"rtsp://127.0.0.1:{port}/x", here=True, timeout=5) as relay,
            pytest.raises(av.FFmpegError),
        ):
            av.open(relay.url, format="rtsp", options={"rtsp_transport": "tcp"}, timeout=5)
        assert "not followed" in str(relay.refusal)
        with pytest.raises(BlockingIOError):
            other.accept()


def test_a_relay_that_nobody_uses_ends_at_once() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"rtsp://127.0.0.1:{server.getsockname()[1]}/x"
        with Stopwatch() as watch, CameraRelay(address, here=True, timeout=60):
            pass
        assert watch.seconds < 10


def test_an_encrypted_camera_that_has_said_half_a_word_still_hears_the_client(
    tmp_path: Path,
) -> None:
    certificate, key = self_signed()
    (tmp_path / "both.pem").write_bytes(certificate + key)
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(tmp_path / "both.pem")
    got, sent = ssl.MemoryBIO(), ssl.MemoryBIO()
    line = context.wrap_bio(got, sent, server_side=True)
    answer, said, heard = b"RTSP/1.0 200 OK\r\nCSeq: 1\r\n\r\n", threading.Event(), []

    def listened(client: socket.socket) -> bytes:
        while True:
            try:
                return line.read(4096)
            except ssl.SSLWantReadError:
                client.sendall(sent.read())
                got.write(client.recv(4096))

    def serve() -> None:
        client, _ = server.accept()
        with client:
            heard.append(listened(client))
            client.sendall(sent.read())
            line.write(answer)
            record = sent.read()
            client.sendall(record[:7])
            said.set()
            heard.append(listened(client))
            client.sendall(record[7:])
            client.recv(4096)

    with socket.create_server(("127.0.0.1", 0)) as server:
        serving = threading.Thread(target=serve, daemon=True)
        serving.start()
        port = server.getsockname()[1]
        with CameraRelay(f"rtsps://127.0.0.1:{port}/x", here=True, timeout=5) as relay:
            door = int(relay.url.split(":")[2].split("/")[0])
            with socket.create_connection(("127.0.0.1", door), 20) as near:
                near.sendall(b"OPTIONS x RTSP/1.0\r\n\r\n")
                assert said.wait(20)
                while select.select([relay._far.fileno()], [], [], 0)[0]:
                    pass
                near.sendall(b"DESCRIBE x RTSP/1.0\r\n\r\n")
                assert near.recv(4096) == answer
        serving.join(20)
    assert [each.split()[0] for each in heard] == [b"OPTIONS", b"DESCRIBE"]
