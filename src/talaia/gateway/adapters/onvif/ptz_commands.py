"""Commands to an ONVIF camera: each asked once, and a way to a preset followed to its end.

A question without an answer is never asked again: whether the camera goes is not known then, and a
person looks at it.
"""

from __future__ import annotations

import asyncio
import math
from typing import TYPE_CHECKING, NamedTuple

from talaia.gateway.adapters.http.fetching import FetchFailed, ServerNotReached
from talaia.gateway.adapters.onvif.answers import PtzPlace
from talaia.gateway.adapters.onvif.ptz_view import NEAR
from talaia.gateway.adapters.onvif.soap import CameraFault
from talaia.gateway.adapters.onvif.xml_nodes import UnreadableXml
from talaia.gateway.ports import CommandOutcome
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine

    from talaia.gateway.adapters.onvif.answers import Preset
    from talaia.gateway.adapters.onvif.ptz_motion import PtzMotion
    from talaia.gateway.adapters.onvif.ptz_service import PtzService
    from talaia.gateway.adapters.onvif.ptz_view import PtzView

__all__ = ["CameraCommands", "CameraOrder"]

# How often it is looked whether it is there (s); and for so long it must rest, for a camera begins
# only after it has answered.
FOLLOW_S = 0.25
SETTLE_S = 0.8
# Of a command's time: so it is told here what became of it, and not by the clock that watches it.
_SHARE = 0.9
_LOST = CommandOutcome(
    CommandPhase.UNKNOWN, "the camera was lost before it was done; look at the camera"
)

_CANCELLED = CommandOutcome(CommandPhase.CANCELLED, "it was stopped, or moved by hand, on its way")


class CameraOrder(NamedTuple):
    """What one command asks: ONVIF's name of it, which preset, and for how long at most (s)."""

    target: str
    preset: str
    seconds: float


class CameraCommands:
    """All commands of one camera. On the event loop."""

    def __init__(self, service: PtzService, motion: PtzMotion, view: PtzView) -> None:
        """Take who is asked, who moves it, and what is known of it."""
        self._service, self._motion, self._view = service, motion, view
        # With what each is to be told when the camera is lost.
        self._tasks: dict[asyncio.Task[None], Callable[[CommandOutcome], None]] = {}

    @property
    def busy(self) -> bool:
        """Whether one is under way."""
        return bool(self._tasks)

    def begin_order(
        self, order: CameraOrder, done: Callable[[CommandOutcome], None]
    ) -> Callable[[], None]:
        """Begin; give what stops it early, from any thread."""
        loop = asyncio.get_running_loop()
        task = loop.create_task(self._run_order(order, done))
        self._tasks[task] = done
        task.add_done_callback(lambda ended: self._tasks.pop(ended, None))

        def stop_early() -> None:
            loop.call_soon_threadsafe(self._motion.stop_now)

        return stop_early

    def lose_all(self) -> None:
        """End all: the camera is not reached any more, and what it does is unknown."""
        for task, done in list(self._tasks.items()):
            done(_LOST)
            task.cancel()
        self._tasks.clear()

    async def _run_order(self, order: CameraOrder, done: Callable[[CommandOutcome], None]) -> None:
        try:
            outcome = await self._outcome_of(order, done)
        except ServerNotReached as error:
            outcome = CommandOutcome(CommandPhase.FAILED, str(error))
        except FetchFailed as error:
            outcome = CommandOutcome(CommandPhase.UNKNOWN, f"{error}; look at the camera")
        except CameraFault as fault:
            outcome = CommandOutcome(CommandPhase.REFUSED, str(fault))
        except UnreadableXml as error:
            outcome = CommandOutcome(
                CommandPhase.UNKNOWN, f"its answer cannot be read ({error}); look at the camera"
            )
        done(outcome)

    async def _outcome_of(
        self, order: CameraOrder, done: Callable[[CommandOutcome], None]
    ) -> CommandOutcome:
        service = self._service
        match order.target:
            case "GotoPreset":
                # As they are now: of a list that is old a name may mean another place.
                self._view.presets = await service.read_presets()
                preset = self._view.find_preset(order.preset)
                if isinstance(preset, str):
                    return CommandOutcome(CommandPhase.REFUSED, preset)
                going = service.goto_preset(preset.token)
                return await self._travel(going, preset.place, order, done)
            case "GotoHomePosition":
                return await self._travel(service.goto_home(), PtzPlace(), order, done)
            case "SetPreset":
                return await self._set_preset(order.preset)
            case "RemovePreset":
                self._view.presets = await service.read_presets()
                preset = self._view.find_preset(order.preset)
                if isinstance(preset, str):
                    return CommandOutcome(CommandPhase.REFUSED, preset)
                await service.remove_preset(preset.token)
            case "SetHomePosition":
                await service.set_home()
            case _:
                self._motion.stop_now()
                await service.stop()
        self._view.presets = await service.read_presets()
        return CommandOutcome(CommandPhase.SUCCEEDED)

    async def _set_preset(self, name: str) -> CommandOutcome:
        if not name.strip() or not name.isprintable():
            return CommandOutcome(CommandPhase.REFUSED, "a preset needs a name")
        before = await self._service.read_presets()
        # One of that name is replaced: two of one name could not be told apart.
        there = [preset for preset in before if preset.name == name]
        if len(there) > 1:
            said = f"{len(there)} presets are called {name!r} already"
            return CommandOutcome(CommandPhase.REFUSED, said)
        await self._service.set_preset(name, there[0].token if there else "")
        self._view.presets = await self._service.read_presets()
        kept: list[Preset] = [one for one in self._view.presets if one.name == name]
        if not kept:
            said = f"the camera took it, and has no preset {name!r} now"
            return CommandOutcome(CommandPhase.FAILED, said)
        if len(kept) > 1:
            said = f"the camera has not replaced {name!r}, and has two of that name now"
            return CommandOutcome(CommandPhase.FAILED, said)
        return CommandOutcome(CommandPhase.SUCCEEDED)

    async def _travel(
        self,
        going: Coroutine[object, object, None],
        goal: PtzPlace,
        order: CameraOrder,
        done: Callable[[CommandOutcome], None],
    ) -> CommandOutcome:
        if not await self._motion.begin_travel():
            going.close()
            return _CANCELLED
        try:
            await going
            if not self._motion.travels:
                # Stopped before its answer came: the two may have arrived the other way round.
                self._motion.stop_now(anew=True)
                return _CANCELLED
            return await self._follow_way(goal, order, done)
        finally:
            self._motion.end_travel()

    async def _follow_way(
        self, goal: PtzPlace, order: CameraOrder, done: Callable[[CommandOutcome], None]
    ) -> CommandOutcome:
        """Look until it rests: where it should, or elsewhere."""
        loop, view = asyncio.get_running_loop(), self._view
        began = loop.time()
        rests_since = began
        while loop.time() - began < order.seconds * _SHARE:
            await asyncio.sleep(FOLLOW_S)
            view.see_status(await self._service.read_status())
            if not self._motion.travels:
                return _CANCELLED
            if view.moving is None:
                said = "the camera took it; it does not tell when it is there"
                return CommandOutcome(CommandPhase.SUCCEEDED, said)
            now = loop.time()
            if view.moving:
                rests_since = now
                done(CommandOutcome(CommandPhase.RUNNING))
            elif now - rests_since >= SETTLE_S:
                return _outcome_at_rest(goal, view)
        said = f"it moves still, after {order.seconds * _SHARE:.0f} s; look at the camera"
        return CommandOutcome(CommandPhase.UNKNOWN, said)


def _outcome_at_rest(goal: PtzPlace, view: PtzView) -> CommandOutcome:
    place = PtzPlace() if view.status is None else view.status.place
    apart = place.distance_to(goal)
    if math.isnan(apart):
        said = "it rests; whether there the camera does not tell"
        return CommandOutcome(CommandPhase.SUCCEEDED, said)
    if apart <= NEAR:
        return CommandOutcome(CommandPhase.SUCCEEDED)
    return CommandOutcome(
        CommandPhase.FAILED,
        f"it rests elsewhere: {_written(place)} instead of {_written(goal)}",
    )


def _written(place: PtzPlace) -> str:
    told = [f"{key} {value:.2f}" for key, value in place._asdict().items() if not math.isnan(value)]
    return ", ".join(told)
