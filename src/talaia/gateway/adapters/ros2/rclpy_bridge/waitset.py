"""A thread on a ROS 2 wait set, with all that belongs to it. Also used by a bridge's own Python.

Why not an executor: rclpy's own costs 115 to 126 µs of CPU for each message, since it rebuilds its
wait set at every turn and wakes for each message; one that drains all ready subscriptions and
then lets 10 ms pass costs a fifth of it, and with 20 ms less. While nothing comes it blocks and
costs nothing. While something comes it does not ask the wait set what is ready: to fill that costs
as much as to try to take from each.

Entities are made, used and destroyed on this thread only, so none can vanish while it is taken
from. Other threads leave jobs.
"""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from functools import partial
from typing import TYPE_CHECKING, Any

from .unlocked_take import UnlockedTake, can_take_unlocked

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

__all__ = ["PACE_S", "WaitThread"]

log = logging.getLogger(__name__)
# From one turn that took something to the next, while nobody looks (s): longer turns cost less.
PACE_S = 0.020
# The same while large messages are taken: of pictures the newest alone waits, and is looked at.
_LARGE_PACE_S = 0.010
# The graph is looked at so often: a new publisher of a latched topic is found within it.
IDLE_NS = 250_000_000
# While the reader above is full: asked again soon, and not in a loop.
HELD_NS = 50_000_000


class WaitThread:
    """Waits, takes, and calls.

    Order of a turn: jobs, wait, take until each subscription is empty, answers of services,
    ``after`` once. An exception in any of the callbacks ends the thread and reaches ``failed``.
    """

    def __init__(
        self,
        *,
        make_wait_set: Callable[[int, int], Any],
        guard: Any,  # noqa: ANN401 - rclpy ships no types
        after: Callable[[], bool],
        idle: Callable[[], None],
        failed: Callable[[BaseException], None],
        paced: Callable[[float], None] | None = None,
    ) -> None:
        """Take what is called.

        Args:
            make_wait_set: makes one for so many subscriptions and clients and the guard.
            guard: a guard condition, to wake the thread.
            after: called after a turn that took something, and when something is held back;
                tells whether anything is still held back.
            idle: called about four times a second, for looking at the graph.
            failed: told how the thread ended if it was not asked to.
            paced: told how long turns are (s) when that changes; where it takes from is to keep up.

        """
        self._make_wait_set = make_wait_set
        self._guard = guard
        self._after = after
        self._idle = idle
        self._failed = failed
        self._paced = paced
        # Appended by any thread and emptied by ours; a deque needs no lock for these two.
        self._jobs: deque[Callable[[], None]] = deque()
        # By the pointer of the handle, as the wait set names what is ready.
        self._subscriptions: dict[
            int, tuple[Any, Callable[[], Any], Callable[[Any, Any], None]]
        ] = {}
        self._clients: dict[int, tuple[Any, Any, Callable[[int, Any], None]]] = {}
        # Read at every turn; set once, by whoever ends the thread.
        self._ended = False
        # From one turn that took something to the next (s).
        self._pace_s = PACE_S
        # Subscriptions of large messages, by their pointers.
        self._large: set[int] = set()
        # What was asked for, by who did; the shortest counts.
        self._paces: dict[str, float] = {}
        self._thread = threading.Thread(target=self._run, name="talaia-ros2", daemon=True)

    # ── any thread ──

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def run_soon(self, job: Callable[[], None]) -> None:
        """Run something on the thread, soon."""
        self._jobs.append(job)
        self._guard.trigger_guard_condition()

    def end(self) -> None:
        """Ask the thread to end and wait for it."""
        self._ended = True
        self._guard.trigger_guard_condition()
        if self._thread.is_alive():
            self._thread.join()

    # ── on the thread ──

    def shorten_turns(self, asker: str, pace_s: float) -> None:
        """Let turns be as short as that (s) for somebody, until asked for `PACE_S` again."""
        self._paces[asker] = pace_s
        shortest_s = min(PACE_S, *self._paces.values())
        if shortest_s != self._pace_s:
            self._pace_s = shortest_s
            if self._paced is not None:
                self._paced(shortest_s)

    def add_subscription(
        self,
        handle: Any,  # noqa: ANN401
        kind: Any,  # noqa: ANN401
        take: Callable[[Any, Any], None],
        *,
        large: bool = False,
    ) -> None:
        """Take raw messages of a subscription, each with its info; ``large`` ones as a view."""
        # Raw; C++ takes no keyword.
        take_next: Callable[[], Any] = partial(handle.take_message, kind, True)  # noqa: FBT003
        if large and can_take_unlocked(handle):
            try:
                take_next = UnlockedTake(handle).take_message
            except (OSError, AttributeError) as error:
                # It costs more, and works.
                log.info("large messages are taken by rclpy: %s", error)
        self._subscriptions[handle.pointer] = (handle, take_next, take)
        if large:
            self._large.add(handle.pointer)
            self.shorten_turns("large", _LARGE_PACE_S)

    def remove_subscription(self, handle: Any) -> None:  # noqa: ANN401
        """Stop taking; the caller destroys it."""
        self._subscriptions.pop(handle.pointer, None)
        self._large.discard(handle.pointer)
        if not self._large:
            self.shorten_turns("large", PACE_S)

    def add_client(
        self,
        handle: Any,  # noqa: ANN401
        kind: Any,  # noqa: ANN401
        take: Callable[[int, Any], None],
    ) -> None:
        """Take a service's answers, each with the number of its request."""
        self._clients[handle.pointer] = (handle, kind, take)

    def remove_client(self, handle: Any) -> None:  # noqa: ANN401
        """Stop taking; the caller destroys it."""
        self._clients.pop(handle.pointer, None)

    def _run(self) -> None:
        try:
            self._turns()
        except BaseException as error:  # noqa: BLE001 - whatever it is, the robot is lost to us
            # An error of a thread that was asked to end is no loss of the robot.
            if not self._ended:
                self._failed(error)

    def _turns(self) -> None:
        next_idle = 0
        wait_set, size = None, (-1, -1)
        held = taken = False
        while not self._ended:
            # First, for a job may add or destroy what would else be waited for.
            while self._jobs:
                self._jobs.popleft()()
            now = time.monotonic_ns()
            if now >= next_idle:
                next_idle = now + IDLE_NS
                self._idle()
            if taken:
                # More has come meanwhile, most likely.
                subscriptions, clients = list(self._subscriptions), list(self._clients)
            else:
                wanted = (len(self._subscriptions), len(self._clients))
                # A wait set is made for a number of entities; filling it anew each time is cheap.
                if wait_set is None or wanted != size:
                    wait_set, size = self._make(wait_set, wanted), wanted
                self._wait(wait_set, HELD_NS if held else max(0, next_idle - now))
                subscriptions = wait_set.get_ready_entities("subscription")
                clients = wait_set.get_ready_entities("client")
            woke = time.monotonic()
            taken = self._take_messages(subscriptions, clients)
            if taken or held:
                held = self._after()
            if taken:
                # Let a few more come before the next turn: waking costs more than taking.
                rest = self._pace_s - (time.monotonic() - woke)
                if rest > 0:
                    time.sleep(rest)
        if wait_set is not None:
            wait_set.destroy_when_not_in_use()

    def _make(self, old: Any, size: tuple[int, int]) -> Any:  # noqa: ANN401
        if old is not None:
            old.destroy_when_not_in_use()
        return self._make_wait_set(*size)

    def _wait(self, wait_set: Any, timeout_ns: int) -> None:  # noqa: ANN401
        wait_set.clear_entities()
        for handle, _, _ in self._subscriptions.values():
            wait_set.add_subscription(handle)
        for handle, _, _ in self._clients.values():
            wait_set.add_client(handle)
        wait_set.add_guard_condition(self._guard)
        wait_set.wait(timeout_ns)

    def _take_messages(self, subscriptions: Sequence[int], clients: Sequence[int]) -> bool:
        taken = False
        for pointer in subscriptions:
            # Till it is empty: ready is told once for a queue that holds many.
            _, take_next, take = self._subscriptions[pointer]
            while True:
                got = take_next()
                if got is None:
                    break
                taken = True
                take(*got)
        for pointer in clients:
            handle, kind, answer = self._clients[pointer]
            while True:
                header, response = handle.take_response(kind)
                if header is None:
                    break
                taken = True
                answer(header.request_id.sequence_number, response)
        return taken
