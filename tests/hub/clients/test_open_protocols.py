"""Which protocols are open: what another process writes is known soon, and costs little else."""

import asyncio

from talaia.clock import SystemClock
from talaia.hub.clients.open_protocols import OpenProtocols
from talaia.hub.store.clients.protocols import ClientProtocols


class Client:
    """Somebody who is connected."""

    def __init__(self) -> None:
        """Be let go by nobody yet."""
        self.ended = asyncio.Event()

    def end(self, _reason: str) -> None:
        self.ended.set()


async def test_who_comes_first_after_another_process_has_shut_a_protocol_is_ended_soon(
    database,
) -> None:
    elsewhere = ClientProtocols(database, SystemClock())
    await elsewhere.set_state("foxglove", is_open=True, origins=(), who="admin")
    protocols = OpenProtocols(ClientProtocols(database, SystemClock()))
    await protocols.reload_table()
    # Nobody is connected: by itself it would look again after 19 seconds.
    watching = asyncio.create_task(protocols.watch(1.0))
    await asyncio.sleep(0)
    await elsewhere.set_state("foxglove", is_open=False, origins=(), who="admin")
    began = asyncio.get_running_loop().time()
    client = Client()
    with protocols.count_client("foxglove", client, None):
        await client.ended.wait()
    assert asyncio.get_running_loop().time() - began < 10
    watching.cancel()
