"""Which hubs are there: by what they said last, and how long ago."""

from hypothesis import given, strategies as st

from talaia.hub.cluster.peers import SILENT_S, TAKE_OVER_S, HubNotice, Peers

S = 1_000_000_000
SILENT_NS = round(SILENT_S * S)


def notice(hub, **more) -> HubNotice:
    return HubNotice(hub=hub, name=more.pop("name", hub), version="1", **more)


def test_a_hub_that_leads_is_found_until_it_is_silent() -> None:
    peers = Peers()
    peers.hear_notice(notice("a", leads=True, epoch=3), 0)
    assert peers.find_lead(SILENT_NS).hub == "a"
    assert peers.find_lead(SILENT_NS + 1) is None


def test_a_hub_that_leaves_is_handed_nothing_more() -> None:
    peers = Peers()
    peers.hear_notice(notice("a", leads=True, epoch=3), 0)
    peers.hear_notice(notice("a", leads=True, epoch=3, leaving=True), 1)
    assert peers.find_lead(2) is None


@given(st.lists(st.tuples(st.sampled_from("abc"), st.integers(1, 9), st.booleans()), max_size=20))
def test_of_two_that_lead_the_newer_one_does(said) -> None:
    peers, newest = Peers(), {}
    for at, (hub, epoch, leads) in enumerate(said):
        peers.hear_notice(notice(hub, leads=leads, epoch=epoch), at)
        newest[hub] = epoch if leads else 0
    lead = peers.find_lead(len(said))
    assert (lead.epoch if lead else 0) == max(newest.values(), default=0)


def test_nobody_is_there_when_the_bus_is_gone() -> None:
    peers = Peers()
    peers.hear_notice(notice("a", leads=True, epoch=3), 0)
    peers.silence_all()
    assert peers.find_lead(1) is None
    assert not peers.is_living("a", 1)


def test_a_hub_that_hands_a_request_over_lives_though_it_has_said_nothing_yet() -> None:
    peers = Peers()
    peers.hear_request("a", 5)
    assert peers.is_living("a", 5 + SILENT_NS)
    assert not peers.is_living("a", 6 + SILENT_NS)
    peers.hear_request("a", 7)
    peers.silence_all()
    assert not peers.is_living("a", 8)


def test_of_hubs_that_only_asked_the_latest_are_remembered() -> None:
    peers = Peers()
    for number in range(1000):
        peers.hear_request(f"hub {number}", number)
    peers.hear_request("hub 900", 1000)
    living = [number for number in range(1000) if peers.is_living(f"hub {number}", 1000)]
    assert living == list(range(800, 1000))


def test_a_hub_that_was_started_anew_stands_once_in_the_list() -> None:
    peers = Peers()
    peers.hear_notice(notice("run one", name="east"), 0)
    peers.hear_notice(notice("run two", name="east"), SILENT_NS + 1)
    assert [known.notice.hub for known in peers] == ["run two"]


def test_while_another_hub_takes_over_nothing_is_handed_to_the_one_before() -> None:
    peers = Peers()
    peers.hear_notice(notice("a", leads=True, epoch=3), 0)
    peers.hear_notice(notice("b", opens=True), 1)
    assert peers.find_lead(2) is None
    assert peers.led_lately(2)
    peers.hear_notice(notice("b", leads=True, epoch=4), 3)
    assert peers.find_lead(4).hub == "b"


def test_one_that_took_over_and_fell_silent_is_waited_for_no_longer_than_others() -> None:
    peers = Peers()
    peers.hear_notice(notice("b", opens=True), 0)
    peers.hear_notice(notice("a", leads=True, epoch=3), SILENT_NS)
    assert peers.find_lead(SILENT_NS + 1).hub == "a"


def test_a_hub_counts_as_led_for_as_long_as_a_take_over_lasts() -> None:
    peers = Peers()
    within_ns = SILENT_NS + round(TAKE_OVER_S * S)
    assert not peers.led_lately(0)
    peers.hear_notice(notice("a", leads=True, epoch=3), 0)
    assert peers.led_lately(within_ns)
    assert not peers.led_lately(within_ns + 1)


def test_a_lead_that_the_database_does_not_answer_leads_no_longer_for_who_waits_its_turn() -> None:
    peers = Peers()
    peers.hear_notice(notice("a", leads=True, epoch=3, database_ms=1.5), 0)
    assert peers.hears_lead(1)
    peers.hear_notice(notice("a", leads=True, epoch=3, database_ms=0.0), 2)
    assert not peers.hears_lead(3)
    peers.hear_notice(notice("b", opens=True), 4)
    assert peers.hears_lead(5)
    assert not peers.hears_lead(5 + SILENT_NS)
