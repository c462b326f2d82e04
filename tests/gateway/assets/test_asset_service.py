"""A hub that asks for files: what it is told, what it gets, and what it never does."""

from __future__ import annotations

import asyncio
import hashlib

import pytest
from patience import PATIENCE_S

from talaia.gateway.assets.asset_outbox import AssetOutbox
from talaia.gateway.assets.asset_reader import AssetReader
from talaia.gateway.assets.asset_service import AssetService
from talaia.gateway.assets.package_index import PackageIndex
from talaia.gateway.tap_ports import ListedTopic
from talaia.wire.frames import ASSET_KIND, AssetRequest, AssetState, asset_file_id

from .package_folders import make_ament_package

TOPIC = ListedTopic("/robot_description", "std_msgs/msg/String", latched=True)
HAND, FOOT = "package://arm/hand.dae", "package://arm/foot.stl"
SKIN = "package://arm/skin.png"
FILES = {"hand.dae": b"<init_from>skin.png</init_from>", "foot.stl": b"foot", "skin.png": b"skin"}


def description(*uris: str) -> bytes:
    return b"".join(f'<mesh filename="{uri}"/>'.encode() for uri in uris)


class Asked:
    """A service that is asked as a hub asks."""

    def __init__(self, tmp_path, *, hands_out: bool = True) -> None:  # noqa: D107
        self.folder = make_ament_package(tmp_path, "arm", FILES)
        index = PackageIndex([tmp_path])
        self.outbox = AssetOutbox(AssetReader(index))
        self.announced = 0
        self._answers: asyncio.Queue[AssetState] = asyncio.Queue()
        self.service = AssetService(
            reader=AssetReader(index) if hands_out else None,
            outbox=self.outbox,
            send=self._answers.put_nowait,
            announce=self._announce,
        )

    def _announce(self) -> None:
        self.announced += 1

    async def ask(self, uri: str, *, fetch: bool = False) -> AssetState:
        self.service.handle_request(AssetRequest(uri=uri, fetch=fetch))
        async with asyncio.timeout(PATIENCE_S):
            return await self._answers.get()


@pytest.fixture
async def asked(tmp_path):
    asked = Asked(tmp_path)
    answering = asyncio.create_task(asked.service.answer_requests())
    yield asked
    answering.cancel()
    await asyncio.gather(answering, return_exceptions=True)


def digest_of(name: str) -> str:
    return hashlib.sha256(FILES[name]).hexdigest()


async def test_nothing_is_told_of_a_file_before_a_description_has_named_it(asked) -> None:
    assert "does not name it" in (await asked.ask(HAND)).problem
    asked.service.hear_message(TOPIC, description(HAND))
    assert (await asked.ask(HAND)).digest == digest_of("hand.dae")
    # A file of the same package that it does not name.
    assert "does not name it" in (await asked.ask(FOOT)).problem
    # Another description: the one before names nothing any more.
    asked.service.hear_message(TOPIC, description(FOOT))
    assert (await asked.ask(FOOT)).digest == digest_of("foot.stl")
    assert (await asked.ask(HAND)).problem


async def test_picture_of_a_mesh_follows_the_mesh(asked) -> None:
    asked.service.hear_message(TOPIC, description(HAND))
    assert (await asked.ask(SKIN)).problem
    await asked.ask(HAND)
    assert (await asked.ask(SKIN)).digest == digest_of("skin.png")


async def test_file_goes_only_when_it_is_wanted_and_as_it_was_told(asked) -> None:
    asked.service.hear_message(TOPIC, description(HAND, FOOT))
    await asked.ask(FOOT)
    assert (asked.outbox.offers(), asked.announced) == ([], 0)
    told = await asked.ask(FOOT, fetch=True)
    (offer,) = asked.outbox.offers()
    assert (offer.id, offer.kind) == (asset_file_id(told.digest), ASSET_KIND)
    assert (offer.size, offer.digest, asked.announced) == (4, told.digest, 1)
    assert asked.outbox.read_part(offer.id, 1, 2) == b"oo"
    # What is written meanwhile does not come into what is on its way.
    (asked.folder / "foot.stl").write_bytes(b"FEET")
    assert asked.outbox.read_part(offer.id, 0, 99) == b"foot"
    asked.outbox.remove(offer.id)
    assert asked.outbox.offers() == []
    # Told before it was changed, and not begun yet: nothing else goes in its place.
    told = await asked.ask(FOOT, fetch=True)
    (asked.folder / "foot.stl").write_bytes(b"HAND")
    with pytest.raises(OSError, match="changed"):
        asked.outbox.read_part(asset_file_id(told.digest), 0, 99)
    assert asked.outbox.offers() == []


async def test_hub_that_is_gone_gets_nothing_of_what_it_has_asked_for(asked) -> None:
    asked.service.hear_message(TOPIC, description(FOOT))
    await asked.ask(FOOT, fetch=True)
    asked.service.link_lost()
    assert asked.outbox.offers() == []
    assert (await asked.ask(FOOT)).digest == digest_of("foot.stl")


async def test_answers_go_on_after_what_cannot_be_read(asked) -> None:
    asked.service.hear_message(TOPIC, description("package://arm/" + "a" * 300 + ".stl", FOOT))
    assert (await asked.ask("package://arm/" + "a" * 300 + ".stl")).problem
    assert (await asked.ask("no name at all")).problem
    assert (await asked.ask(FOOT)).digest == digest_of("foot.stl")


async def test_files_of_a_robot_are_bounded_together(asked) -> None:
    names = [f"{number}.stl" for number in range(9)]
    for name in names:
        with (asked.folder / name).open("wb") as file:
            file.truncate(31 * 1024 * 1024)
    asked.service.hear_message(TOPIC, description(*(f"package://arm/{name}" for name in names)))
    told = [await asked.ask(f"package://arm/{name}") for name in names]
    assert [bool(state.problem) for state in told] == [False] * 8 + [True]


async def test_gateway_that_is_told_so_hands_out_nothing(tmp_path) -> None:
    asked = Asked(tmp_path, hands_out=False)
    answering = asyncio.create_task(asked.service.answer_requests())
    asked.service.hear_message(TOPIC, description(FOOT))
    assert "--no-meshes" in (await asked.ask(FOOT)).problem
    answering.cancel()
    await asyncio.gather(answering, return_exceptions=True)


async def test_hub_that_asks_without_end_is_told_so(tmp_path) -> None:
    asked = Asked(tmp_path)
    for number in range(2_000):
        asked.service.handle_request(AssetRequest(uri=f"package://arm/{number}.stl"))
    assert "at once" in (await asked.ask(FOOT)).problem
