"""Texts and trees without their secrets."""

from __future__ import annotations

import time

import pytest
from hypothesis import given, strategies as st

from talaia.cli.support.redaction import MASK, Redactor

PEM = """-----BEGIN EC PRIVATE KEY-----
MHcCAQEEIPl4nt3dk3yS3cr3tAAAAoAoGCCqGSM49AwEHoUQDQgAE
-----END EC PRIVATE KEY-----"""

TEXTS = {
    "an address": ("dials postgresql://talaia:hunter2@db/talaia", "hunter2"),
    "an address with signs": ("rtsp://cam:p@ss/w:rd@10.0.0.5/stream", "p@ss/w:rd"),
    "a query": ("GET /ws?access_token=s3same&rate=5", "s3same"),
    "a header": ("Authorization: Talaia site=agv, proof=opensesame", "opensesame"),
    "a cookie": ("Set-Cookie: __Host-talaia=opensesame; Secure", "opensesame"),
    "bearer": ("sent bearer opensesame to it", "opensesame"),
    "a name": ("mqtt_password = opensesame", "opensesame"),
    "JSON": ('{"client_secret": "open sesame", "x": 1}', "open sesame"),
    "a Python dict": ("{'api_key': 'open sesame'}", "open sesame"),
    "an option": ("started with --bot-token opensesame --port 1", "opensesame"),
    "an option with =": ("started with --password=opensesame", "opensesame"),
    "curl": ("ran curl -u ada:opensesame http://x", "opensesame"),
    "a recovery code": ("used the recovery code RC-4410 of ada", "RC-4410"),
    "a second factor": ("the verification code is 991177", "991177"),
    "a sentence": ("the password is hunter2, he said", "hunter2"),
    "a private key": (f"read\n{PEM}\nand more", "MHcCAQEEIPl4nt3dk3yS3cr3t"),
    "a private key cut off": (PEM[:80], "MHcCAQEEIPl4nt3dk3yS3cr3t"),
    "our token": ("used tal_Zk3hQ9-abc_defgh", "Zk3hQ9"),
    "a forge's token": ("cloned with ghp_abcdefghij", "abcdefghij"),
    "a web token": ("got eyJhbGciOi.eyJzdWIiOi.c2lnbmF0", "eyJzdWIiOi"),
    "a bot": ("sent to 123456789:AAHdqTcvCH1vGWJxfSeofSAs0K5PALDsaw", "AAHdqTcvCH1"),
    "Apprise": ("failed: tgram://bottoken/chatid", "bottoken"),
    "at random": ("the link is /setup/q3J8-kfUw0a_PZ6mBvT2xY", "q3J8-kfUw0a"),
    "hexadecimal": ("key of 0a1b2c3d4e5f60718293a4b5c6d7e8f9", "0a1b2c3d4e5f"),
    "mail": ("mailed to ada@observatory.example", "ada@"),
}


@pytest.mark.parametrize("name", TEXTS)
def test_what_looks_like_a_secret_is_masked_and_the_rest_stays(name: str) -> None:
    text, secret = TEXTS[name]
    cleaned = Redactor().clean_text(text)
    assert secret not in cleaned
    assert MASK in cleaned
    # Once more changes nothing that was said.
    assert secret not in Redactor().clean_text(cleaned)


def test_a_log_stays_a_log() -> None:
    text = (
        "2026-11-27 05:12:44,120 WARNING talaia.gateway.uplink.connection: the hub cannot be "
        "reached: [Errno 111] Connect call failed ('127.0.0.1', 8443); tried again in 2.5 s\n"
        '  File "/usr/lib/python3.11/asyncio/base_events.py", line 1106, in create_connection\n'
        "unit talaia-gateway-north_dome_2.service ended after 00:10:59\n"
        "a record of camera_front_left_compressed_image took 12345678901234567890 us\n"
    )
    assert Redactor().clean_text(text) == text


def test_a_known_secret_is_masked_wherever_and_however_it_stands() -> None:
    redactor = Redactor(["seagull", "two words/"])
    text = "seagulls, 'two words/' and two%20words%2F"
    assert redactor.clean_text(text) == f"{MASK}s, '{MASK}' and {MASK}"
    assert redactor.find_known(text) == 3
    assert redactor.find_known(redactor.clean_text(text)) == 0


def test_words_of_programs_keep_their_names_of_options_alone() -> None:
    words = ["gateway", "site.yaml", "--key-file=agv.key", "-u", "ada:x", "{ra}"]
    assert Redactor().clean_words(words) == [
        *("gateway", MASK, f"--key-file={MASK}", "-u", MASK, "{ra}")
    ]


def test_a_tree_loses_what_stands_at_names_of_secrets() -> None:
    tree = {
        "site": "agv",
        "pin": 4711,
        "connections": {"web": {"headers": {"X-Thing": "opensesame"}, "token_file": "t"}},
        "devices": [{"run": "dome_client -k opensesame status", "name": "Dome"}],
    }
    assert Redactor().clean_tree(tree) == {
        "site": "agv",
        "pin": MASK,
        "connections": {"web": {"headers": {"X-Thing": MASK}, "token_file": MASK}},
        "devices": [{"run": f"dome_client -k {MASK} {MASK}", "name": "Dome"}],
    }


@given(st.text(alphabet="abcdefghijkmnpqrstuvwxyz23456789!$%&+-_/@", min_size=4, max_size=40))
def test_a_password_that_is_known_is_never_left(secret: str) -> None:
    redactor = Redactor([secret])
    text = f"url=amqp://u:{secret}@h/ x {secret}\n{secret}{secret} password={secret}"
    assert secret not in redactor.clean_text(text)


def test_long_lines_take_no_more_than_their_length() -> None:
    began = time.process_time()
    for line in ("a" * 2_000, "a-" * 1_000, "key" * 700, "://" * 700, "&a=" * 700, "--key" * 400):
        Redactor().clean_text(line)
    assert time.process_time() - began < 2
