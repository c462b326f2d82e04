"""What a store's refusals mean, by the texts that the library gives; nothing of them is shown."""

from __future__ import annotations

import logging

import pytest

from talaia.hub.files.store_failures import describe_failure
from talaia.hub.files.store_health import StoreHealth, StoreUse

pytestmark = pytest.mark.pure


def refused(status: int, phrase: str, code: str) -> str:
    body = f"<Error><Code>{code}</Code><AWSAccessKeyId>AKIDSHOWN</AWSAccessKeyId></Error>"
    return (
        "Generic S3 error: Error performing PUT http://127.0.0.1:1/robots/certificate in 1ms -"
        f" Server returned non-2xx status code: {status} {phrase}: {body}\n\nDebug source:\n"
        f"RetryErrorImpl {{ retry_timeout: 1s, inner: Status {{ status: {status}, body: {body} "
    )


def lost(inner: str) -> str:
    return (
        "Generic S3 error: Error performing HEAD https://store/robots/a in 1ms - HTTP error: error"
        f" sending request\n\nDebug source:\nRetryErrorImpl {{ retry_timeout: 10s, inner: {inner}"
    )


@pytest.mark.parametrize(
    ("said", "why", "full"),
    [
        (refused(403, "Forbidden", "SignatureDoesNotMatch"), "refuses the key", False),
        (refused(403, "Forbidden", "InvalidAccessKeyId"), "refuses the key", False),
        (refused(401, "Unauthorized", ""), "refuses the key (401)", False),
        (refused(403, "Forbidden", "QuotaExceeded"), "has no room (QuotaExceeded)", True),
        (refused(507, "Insufficient Storage", ""), "has no room (507)", True),
        (refused(404, "Not Found", "NoSuchBucket"), "has no such bucket", False),
        (refused(503, "Slow Down", "SlowDown"), "is busy (SlowDown)", False),
        (refused(403, "Forbidden", "RequestTimeTooSkewed"), "clock is wrong", False),
        (refused(500, "Internal Server Error", "InternalError"), "answers with Internal", False),
        (lost("HttpError { kind: Timeout, source: TimedOut }"), "does not answer in time", False),
        (lost('kind: Connect, "tcp connect error", ConnectionRefused'), "cannot be reached", False),
        (lost('kind: Connect, "dns error", "failed to lookup"'), "name that is not known", False),
        (lost("kind: Connect, InvalidCertificate(UnknownIssuer)"), "not trusted", False),
        ("something else", "does not answer", False),
    ],
)
def test_a_failure_is_said_in_words_without_what_the_store_said(said, why, full) -> None:
    failure = describe_failure(said)
    assert why in failure.why
    assert failure.full is full
    assert failure.remedy
    assert "AKIDSHOWN" not in str(failure)


def test_a_loss_is_logged_once_and_its_end_once(caplog) -> None:
    caplog.set_level(logging.INFO)
    health = StoreHealth("s3://robots")
    for _ in range(5):
        health.report_failure(StoreUse.READ, "cannot be reached")
    health.report_failure(StoreUse.READ, "does not answer in time")
    assert health.trouble == "the store of files does not answer in time"
    # What is full is written no more, and read as ever.
    health.report_success(StoreUse.WRITE)
    assert health.trouble
    for _ in range(3):
        health.report_success(StoreUse.READ)
    assert health.trouble == ""
    assert [record.levelname for record in caplog.records] == ["ERROR", "WARNING"]
