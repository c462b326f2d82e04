"""Options that say where signed heads of the audit log go."""

from __future__ import annotations

import argparse

import pytest

from talaia.hub.audit_options import add_audit_options

pytestmark = pytest.mark.pure


def read(*argv: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    add_audit_options(parser)
    return parser.parse_args(argv)


def test_heads_are_mailed_to_nobody_or_once_a_day_to_one_address() -> None:
    assert (read().audit_mail, read().audit_mail_hours) == (None, 24.0)
    asked = read("--audit-mail", "audit@example.org", "--audit-mail-hours", "1")
    assert (asked.audit_mail, asked.audit_mail_hours) == ("audit@example.org", 1.0)


@pytest.mark.parametrize("address", ["audit", "a@b.org,c@d.org", "a@b.org\nBcc: c@d.org", "<a@b>"])
def test_what_is_not_one_mail_address_is_refused_in_words(address, capsys) -> None:
    with pytest.raises(SystemExit):
        read("--audit-mail", address)
    assert "is no mail address; write one, like audit@example.org" in capsys.readouterr().err


@pytest.mark.parametrize("hours", ["0.5", "-1", "nan", "inf", "often"])
def test_mails_come_no_more_often_than_heads_are_made(hours, capsys) -> None:
    with pytest.raises(SystemExit):
        read(f"--audit-mail-hours={hours}")
    assert "is no number of hours of at least 1" in capsys.readouterr().err
