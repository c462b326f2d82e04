"""Cameras are found by multicast; what strangers answer is believed only of themselves."""

from __future__ import annotations

import socket
import struct
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING

from hypothesis import given, strategies as st

from talaia.gateway.adapters.onvif.search import parse_matches, search_cameras
from talaia.gateway.adapters.onvif.xml_nodes import parse_xml

if TYPE_CHECKING:
    from collections.abc import Iterator

GROUP = "239.255.77.88"
QUESTION = "urn:uuid:00000000-0000-0000-0000-000000000001"


def answer(
    addresses: str, relates_to: str = QUESTION, scopes: str = "", wrapper: str = "d:ProbeMatches"
) -> bytes:
    begin, end = (f"<{wrapper}>", f"</{wrapper}>") if wrapper else ("", "")
    return (
        '<s:Envelope xmlns:s="http://www.w3.org/2003/05/soap-envelope"'
        ' xmlns:a="http://schemas.xmlsoap.org/ws/2004/08/addressing"'
        ' xmlns:d="http://schemas.xmlsoap.org/ws/2005/04/discovery"><s:Header>'
        f"<a:RelatesTo>{relates_to}</a:RelatesTo></s:Header><s:Body>{begin}<d:ProbeMatch>"
        f"<d:Scopes>{scopes}</d:Scopes><d:XAddrs>{addresses}</d:XAddrs></d:ProbeMatch>{end}"
        "</s:Body></s:Envelope>"
    ).encode()


@contextmanager
def peer(answers: list[bytes]) -> Iterator[int]:
    """Answer each question that comes to the group on this computer."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.bind(("127.0.0.1", 0) if not answers else ("", 0))
        joined = struct.pack("4s4s", socket.inet_aton(GROUP), socket.inet_aton("127.0.0.1"))
        line.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, joined)
        line.settimeout(0.05)
        ended = threading.Event()

        def serve() -> None:
            while not ended.is_set():
                try:
                    data, asker = line.recvfrom(65_535)
                except TimeoutError:
                    continue
                asked = parse_xml(data).text_at("Header", "MessageID")
                for each in answers:
                    line.sendto(each.replace(QUESTION.encode(), asked.encode()), asker)

        thread = threading.Thread(target=serve)
        thread.start()
        try:
            yield line.getsockname()[1]
        finally:
            ended.set()
            thread.join()


def test_a_camera_that_answers_is_found_once_with_its_name() -> None:
    scopes = "onvif://www.onvif.org/name/Yard%20%3Cb%3E onvif://www.onvif.org/hardware/D1 urn:other"
    good = answer("http://192.0.2.9/onvif http://127.0.0.1:81/onvif/device_service", scopes=scopes)
    with peer([b"\x00no XML", answer("http://127.0.0.1:82/", "urn:another"), good, good]) as port:
        found = search_cameras(1.0, group=GROUP, port=port)
    assert found == [("http://127.0.0.1:81/onvif/device_service", "Yard <b>", "D1")]


def test_nobody_there_is_an_empty_list() -> None:
    with peer([]) as port:
        assert search_cameras(0.1, group=GROUP, port=port) == []


def test_only_an_address_of_the_one_who_answers_counts() -> None:
    wrong = [
        "http://192.0.2.9/onvif/device_service",
        "http://camera.example/onvif/device_service",
        "http://127.0.0.1@192.0.2.9/",
        "http://user:secret@192.0.2.8/",
        "ftp://192.0.2.8/",
        "http://192.0.2.8:0/",
        "http://192.0.2.8:99999/",
        "http://192.0.2.8/?leads=elsewhere",
        "file:///etc/hostname",
        "http://[::1/",
        "http://192.0.2.8/" + "a" * 400,
    ]
    for address in wrong:
        assert parse_matches(answer(address), "192.0.2.8", QUESTION) == []
    right = answer(" ".join([*wrong, "http://192.0.2.8:8000/onvif"]))
    assert [one.url for one in parse_matches(right, "192.0.2.8", QUESTION)] == [
        "http://192.0.2.8:8000/onvif"
    ]


def test_an_answer_without_the_list_around_it_counts_and_one_to_another_question_does_not() -> None:
    bare = answer("http://192.0.2.8/onvif", wrapper="")
    assert len(parse_matches(bare, "192.0.2.8", QUESTION)) == 1
    assert parse_matches(bare, "192.0.2.8", "urn:uuid:another") == []


@given(st.binary(max_size=300) | st.text(max_size=300).map(str.encode))
def test_whatever_comes_is_read_or_is_no_camera(data: bytes) -> None:
    assert parse_matches(data, "192.0.2.8", QUESTION) == []
    parse_matches(answer("http://192.0.2.8/").replace(b"ProbeMatch", data[:20]), "::1", QUESTION)
