"""What a page is told of a gateway's message, and what a page can never say."""

from __future__ import annotations

from typing import get_args

import msgspec
import pytest

from talaia.wire import browser, frames
from talaia.wire.browser_messages.relay import relay_message, shared_fields

from .test_codec import full

RELAYED = [
    (browser.TickUpdate, frames.ControlTick),
    (browser.DriveUpdate, frames.DriveState),
    (browser.StopUpdate, frames.StopState),
    (browser.CommandUpdate, frames.CommandState),
    (browser.EventUpdate, frames.Event),
    (browser.NightUpdate, frames.NightState),
]


@pytest.mark.parametrize(("update", "told"), RELAYED, ids=lambda shape: shape.__name__)
def test_a_page_is_told_each_field_as_the_gateway_said_it_and_the_site(update, told) -> None:
    said = full(told)
    news = msgspec.structs.asdict(relay_message(update, said, "hill"))
    assert news.pop("site") == "hill"
    assert news == {name: getattr(said, name) for name in news}
    assert set(news) == set(shared_fields(update, told))


def test_a_field_that_only_the_gateways_message_has_does_not_reach_a_page() -> None:
    assert "over" in frames.CommandState.__struct_fields__
    assert "over" not in shared_fields(browser.CommandUpdate, frames.CommandState)


def test_what_the_hub_knows_better_takes_the_place_of_what_was_said() -> None:
    said = frames.CommandState(
        id="1", device="base", command="park", phase=frames.CommandPhase.RUNNING, acting_s=1.0
    )
    news = relay_message(browser.CommandUpdate, said, "hill", who="anna", acting_s=3.0)
    assert (news.who, news.acting_s, news.command) == ("anna", 3.0, "park")


@pytest.mark.parametrize("update", get_args(browser.ToBrowser), ids=lambda shape: shape.__name__)
def test_no_page_is_told_a_session(update) -> None:
    assert "session" not in update.__struct_fields__


@pytest.mark.parametrize("asked", get_args(browser.FromBrowser), ids=lambda shape: shape.__name__)
def test_no_page_can_say_who_it_is_or_which_session(asked) -> None:
    assert not {"who", "session"} & set(asked.__struct_fields__)
