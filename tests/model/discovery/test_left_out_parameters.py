"""Which parameters a description never has."""

from __future__ import annotations

import pytest

from talaia.model.discovery.left_out_parameters import is_secret, reason_to_leave


@pytest.mark.parametrize(
    "name",
    ["wifi_password", "/cloud/api/Key", "cloud/key/value", "ssh.key", "API_KEY", "authToken",
     "db.pwd", "mqttPassphrase"],
)  # fmt: skip
def test_a_secret_is_known_by_its_name_or_its_name_space(name: str) -> None:
    assert is_secret(name)
    assert reason_to_leave(name, "text", 1) == "by its name it is a secret"


@pytest.mark.parametrize("name", ["keyframes", "turnkey_speed", "monkey", "led_pin", "gain"])
def test_what_only_resembles_a_secret_is_kept(name: str) -> None:
    assert reason_to_leave(name, "number") == ""


def test_long_texts_and_what_is_no_single_value_are_left_out_with_the_reason() -> None:
    assert reason_to_leave("frame", "text", 200) == ""
    assert reason_to_leave("frame", "text", 201) == "a text of 201 characters"
    assert reason_to_leave("gains", None) == (
        "it is no number, truth or text, nor a list of one of these"
    )
    assert reason_to_leave("gains", "numbers", 400) == ""
    assert reason_to_leave("gains", "numbers", 401) == "a list that takes 401 characters"
