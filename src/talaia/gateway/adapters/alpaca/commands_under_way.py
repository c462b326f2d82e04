"""Commands to Alpaca devices: each method called once, then followed until its goal is reached.

A call whose answer does not come is never made again: whether the device has begun is not known,
and a second call may undo the first. It ends as *unknown*, and a person reads the device.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, NamedTuple

from talaia.gateway.adapters.alpaca.goals import ABSENT, AlpacaGoal, row_of
from talaia.gateway.adapters.alpaca.protocol import NOT_IMPLEMENTED, AlpacaRefused
from talaia.gateway.adapters.http.fetching import FetchFailed, ServerNotReached
from talaia.gateway.ports import CommandOutcome
from talaia.model.connection import alpaca_device_of
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.clock import Clock
    from talaia.gateway.adapters.alpaca.camera_pictures import CameraPictures
    from talaia.gateway.adapters.alpaca.protocol import Scalar
    from talaia.gateway.adapters.alpaca.server import AlpacaServer

__all__ = ["AlpacaCall", "AlpacaCommands", "call_of"]

log = logging.getLogger(__name__)
_FOLLOW_S = 0.4
_FITS = "fits"
# Of a command's time: so it is told here what became of it, and not by the clock that watches it.
_SHARE = 0.9
# A setting before the method itself answers at once.
_PRESET_S = 10.0


class AlpacaCall(NamedTuple):
    """What one command asks.

    Attributes:
        described: the device in the description.
        target: the method, ``camera/0/startexposure``.
        presets: methods of the same device that are called before, with their parameters.
        fields: the method's own parameters.
        cards: keywords for the picture's header.
        seconds: how long it may go without an answer.

    """

    described: str
    target: str
    presets: tuple[tuple[str, dict[str, Scalar]], ...]
    fields: dict[str, Scalar]
    cards: dict[str, Scalar]
    seconds: float


def call_of(described: str, target: str, given: Mapping[str, Scalar], seconds: float) -> AlpacaCall:
    """Sort a command's fields: ``binx/BinX`` is set before, ``fits/OBJECT`` is for the header."""
    device = alpaca_device_of(target)
    presets: dict[str, dict[str, Scalar]] = {}
    fields: dict[str, Scalar] = {}
    cards: dict[str, Scalar] = {}
    for field, value in given.items():
        method, _, name = field.rpartition("/")
        if method == _FITS:
            cards[name] = value
        elif method:
            presets.setdefault(f"{device}/{method}", {})[name] = value
        else:
            fields[name] = value
    return AlpacaCall(described, target, tuple(presets.items()), fields, cards, seconds)


class AlpacaCommands:
    """All commands of one connection. On the event loop."""

    def __init__(self, clock: Clock, pictures: CameraPictures) -> None:
        """Take the clock, and who fetches a camera's picture."""
        self._clock, self._pictures = clock, pictures
        # With what each is to be told when the server is lost.
        self._tasks: dict[asyncio.Task[None], Callable[[CommandOutcome], None]] = {}

    def begin_call(
        self, server: AlpacaServer, call: AlpacaCall, done: Callable[[CommandOutcome], None]
    ) -> Callable[[], None] | None:
        """Begin; give what stops it early, from any thread, or none where it has no stop."""
        loop = asyncio.get_running_loop()
        stopping = asyncio.Event()
        task = loop.create_task(self._run_call(server, call, done, stopping))
        self._tasks[task] = done
        task.add_done_callback(self._end_task)
        if not row_of(call.target).stop:
            return None

        def stop_early() -> None:
            loop.call_soon_threadsafe(stopping.set)

        return stop_early

    def stop_device(self, server: AlpacaServer, target: str) -> None:
        """Call a device's stop, whatever is under way; its answer is not waited for."""
        task = asyncio.get_running_loop().create_task(_call_stop(server, target))
        self._tasks[task] = _forget_outcome
        task.add_done_callback(self._end_task)

    def lose_all(self) -> None:
        """The server is gone: nobody knows what became of what is under way."""
        tasks, self._tasks = self._tasks, {}
        for task, done in tasks.items():
            task.cancel()
            words = "the Alpaca server was lost meanwhile; look at the device"
            done(CommandOutcome(CommandPhase.UNKNOWN, words))

    def _end_task(self, task: asyncio.Task[None]) -> None:
        done = self._tasks.pop(task, None)
        if done is None or task.cancelled() or task.exception() is None:
            return
        # A fault of ours must not leave a command without an end.
        log.error("a command ended by an error", exc_info=task.exception())
        done(CommandOutcome(CommandPhase.UNKNOWN, "it ended by an error of the gateway"))

    async def _run_call(
        self,
        server: AlpacaServer,
        call: AlpacaCall,
        done: Callable[[CommandOutcome], None],
        stopping: asyncio.Event,
    ) -> None:
        refused = await _make_presets(server, call)
        outcome = refused or await _call_method(server, call)
        if outcome is not None:
            done(outcome)
            return
        goal = AlpacaGoal(call.target, call.fields, self._clock.monotonic_ns())
        if not goal.properties:
            done(CommandOutcome(CommandPhase.SUCCEEDED, "the device has taken it"))
            return
        began_ns = self._clock.wall_ns()
        scene = (
            asyncio.ensure_future(self._pictures.read_scene(server, call))
            if goal.row.picture
            else None
        )
        try:
            ended = await self._follow_goal(server, call, goal, done=done, stopping=stopping)
            if scene is not None and ended.phase is CommandPhase.SUCCEEDED:
                done(CommandOutcome(CommandPhase.RUNNING, "", 1.0))
                ended = await self._pictures.keep_picture(server, call, await scene, began_ns)
        finally:
            if scene is not None:
                scene.cancel()
        done(ended)

    async def _follow_goal(
        self,
        server: AlpacaServer,
        call: AlpacaCall,
        goal: AlpacaGoal,
        *,
        done: Callable[[CommandOutcome], None],
        stopping: asyncio.Event,
    ) -> CommandOutcome:
        device = alpaca_device_of(call.target)
        while True:
            if stopping.is_set() and not goal.cancelled:
                goal.cancelled = True
                await _call_stop(server, f"{device}/{goal.row.stop}")
            values = await _read_values(server, device, goal.properties)
            outcome = goal.evaluate_values(values, self._clock.monotonic_ns())
            if outcome is not None and outcome.phase is not CommandPhase.RUNNING:
                return outcome
            # Nothing is said while nothing is known: the command's own time-out ends that.
            if outcome is not None:
                done(outcome)
            try:
                async with asyncio.timeout(_FOLLOW_S):
                    # Its end is a wish to stop, which is not to wait for the next look.
                    await (stopping.wait() if not goal.cancelled else asyncio.sleep(_FOLLOW_S))
            except TimeoutError:
                pass


async def _make_presets(server: AlpacaServer, call: AlpacaCall) -> CommandOutcome | None:
    for method, fields in call.presets:
        try:
            await server.put_method(method, fields, _PRESET_S)
            await _follow_binning(server, method, fields)
        except AlpacaRefused as error:
            return CommandOutcome(CommandPhase.REFUSED, f"{method}: {error}")
        except FetchFailed as error:
            return CommandOutcome(CommandPhase.FAILED, f"{method}: {error}; no more was asked")
    return None


async def _call_method(server: AlpacaServer, call: AlpacaCall) -> CommandOutcome | None:
    """Call it, once; none when the device has taken it."""
    try:
        await server.put_method(call.target, call.fields, call.seconds * _SHARE)
        await _follow_binning(server, call.target, call.fields)
    except AlpacaRefused as error:
        phase = CommandPhase.REFUSED if error.refused else CommandPhase.FAILED
        return CommandOutcome(phase, str(error))
    except ServerNotReached as error:
        return CommandOutcome(CommandPhase.FAILED, f"{error}; nothing was sent")
    except FetchFailed as error:
        words = f"{error}; it was sent once and is not sent again: look at the device"
        return CommandOutcome(CommandPhase.UNKNOWN, words)
    return None


async def _follow_binning(server: AlpacaServer, target: str, fields: Mapping[str, Scalar]) -> None:
    """After ``BinX``: the other axis likewise, and the whole chip in its pixels.

    A camera counts its frame in binned pixels, and refuses one that is larger than its chip.

    Raises:
        AlpacaRefused: the camera refuses it.
        FetchFailed: it does not answer.

    """
    factor = fields.get("BinX")
    if not target.endswith("/binx") or not isinstance(factor, int | float) or factor < 1:
        return
    camera = alpaca_device_of(target)
    await server.put_method(f"{camera}/biny", {"BinY": factor}, _PRESET_S)
    for axis in "xy":
        try:
            size = await server.ask_property(f"{camera}/camera{axis}size")
        except AlpacaRefused:
            continue
        if isinstance(size, int) and not isinstance(size, bool):
            upper = axis.upper()
            await server.put_method(f"{camera}/start{axis}", {f"Start{upper}": 0}, _PRESET_S)
            whole = {f"Num{upper}": int(size // factor)}
            await server.put_method(f"{camera}/num{axis}", whole, _PRESET_S)


async def _read_values(
    server: AlpacaServer, device: str, properties: list[str]
) -> dict[str, object]:
    """Ask for what a goal looks at; what does not answer is missing."""
    values: dict[str, object] = {}
    for name in properties:
        try:
            values[name] = await server.ask_property(f"{device}/{name}")
        except AlpacaRefused as error:
            if error.number == NOT_IMPLEMENTED:
                values[name] = ABSENT
        except FetchFailed:
            break
    return values


async def _call_stop(server: AlpacaServer, target: str) -> None:
    try:
        await server.put_method(target, {}, _PRESET_S)
    except (FetchFailed, AlpacaRefused) as error:
        # What the device does shows in its signals; a stop that fails is no end of the command.
        log.warning("%s: %s", target, error)


def _forget_outcome(_: CommandOutcome) -> None:
    """Tell nobody: a stop has no command."""
