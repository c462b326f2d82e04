"""The file that names a broker: what is not safe, or not meant so, keeps the hub from starting."""

from __future__ import annotations

import pytest

from talaia.hub.clients.mqtt.broker_settings import read_broker_settings
from talaia.hub.clients.mqtt.known_topics import KnownTopics
from talaia.hub.clients.mqtt.retained_topics import RetainedTopics
from talaia.hub.errors import CannotStart

REST = "token_file: token\nsites: {agv: {signals: ['*']}}\n"
REFUSED = {
    "plain over the network": ("broker: {host: b.example, tls: false}\n" + REST, "on the way"),
    "no broker": (REST, "broker"),
    "an unknown key": ("broker: {host: b, user: x}\n" + REST, "user"),
    "wildcards in the prefix": ("broker: {host: b}\nprefix: a/#\n" + REST, "prefix"),
    "the broker's own topics": ("broker: {host: b}\nprefix: $SYS\n" + REST, "prefix"),
    "a host that is none": ("broker: {host: 'mqtt://b'}\n" + REST, "host"),
    "no sites": ("broker: {host: b}\ntoken_file: token\n", "sites"),
    "too often": ("broker: {host: b}\nevery_s: 0\n" + REST, "every_s"),
    "code": ("!!python/object/apply:os.system [true]", "python"),
    "no mapping": ("- 1", "object"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_not_safe_is_refused_with_the_place(tmp_path, case) -> None:
    text, why = REFUSED[case]
    path = tmp_path / "mqtt.yaml"
    path.write_text(text)
    with pytest.raises(CannotStart, match=r"mqtt\.yaml") as refused:
        read_broker_settings(path)
    assert why in str(refused.value)


def test_file_is_read_and_files_in_it_are_meant_from_its_folder_on(tmp_path) -> None:
    path = tmp_path / "mqtt.yaml"
    path.write_text("broker: {host: b.example, ca: ca.pem}\n" + REST)
    read = read_broker_settings(path)
    assert (read.broker.number, read.broker.tls) == (8883, True)
    assert read.broker.ca == str(tmp_path / "ca.pem")
    assert read.token_file == str(tmp_path / "token")
    # Nothing is permitted that is not named.
    assert not read.sites["agv"].has_command("base/turn")
    assert read.home_assistant == ""


def test_what_an_earlier_run_published_is_cleared_and_only_there(tmp_path) -> None:
    kept = KnownTopics(tmp_path / "topics.json")
    kept.save_topics("b:1", ["t/a", "t/b"])
    assert kept.load_topics("other:1") == []
    topics = RetainedTopics(kept.load_topics("b:1"))
    topics.restart_connection()
    topics.set_payload("t/a", b"1")
    topics.keep_only({"t/a"})
    assert {topics.take_due(), topics.take_due()} == {("t/a", b"1"), ("t/b", b"")}
    topics.confirm_cleared("t/b")
    assert topics.known == {"t/a"}


def test_slow_broker_is_told_the_newest_of_each_topic() -> None:
    topics = RetainedTopics()
    for value in range(1000):
        topics.set_payload("t/a", b"%d" % value)
        topics.set_payload("t/b", b"same")
    assert topics.take_due() == ("t/a", b"999")
    assert topics.take_due() == ("t/b", b"same")
    assert topics.take_due() is None
    # Nothing new: it is not told again.
    topics.set_payload("t/b", b"same")
    assert not topics.has_due
    topics.withhold_values()
    topics.restart_connection()
    assert topics.take_due() is None
