"""What a gateway was handed down is known again, by the hub that made it and for that gateway."""

from __future__ import annotations

from talaia.clock import SystemClock
from talaia.hub.auth.resume_tokens import ResumeTokens
from talaia.wire.gateway_proof import KeyProof, ResumeToken, resume_answer

PATH = "/gateway/link"


def shown(text: str) -> KeyProof:
    lineage, serial, secret = text.split(".")
    answer = resume_answer(bytes.fromhex(secret), nonce="n", site="agv", path=PATH)
    return KeyProof("agv", "n", "00", ResumeToken(int(lineage), int(serial)), answer)


def test_it_is_known_again_over_a_restart_and_by_no_other_hub() -> None:
    hub = ResumeTokens(lambda: b"k" * 32, SystemClock())
    token = hub.issue_token()
    said = shown(hub.write_token(3, token))
    restarted = ResumeTokens(lambda: b"k" * 32, SystemClock())
    assert restarted.read_token(3, said, PATH) == token
    # Of another key of the site, on another path, for another number, of another hub.
    assert restarted.read_token(4, said, PATH) is None
    assert restarted.read_token(3, said, "/gateway/media") is None
    assert restarted.read_token(3, said._replace(nonce="m"), PATH) is None
    assert ResumeTokens(lambda: b"l" * 32, SystemClock()).read_token(3, said, PATH) is None


def test_numbers_rise_however_quickly_they_are_made_and_the_first_begins_a_line() -> None:
    hub = ResumeTokens(lambda: b"k" * 32, SystemClock())
    first = hub.issue_token()
    later = [hub.issue_token(first.lineage) for _ in range(100)]
    assert first.lineage == first.serial
    assert {token.lineage for token in later} == {first.lineage}
    assert sorted({token.serial for token in later}) == [token.serial for token in later]
