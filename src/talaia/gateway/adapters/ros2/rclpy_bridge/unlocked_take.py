"""Large messages taken without the interpreter's lock, and into memory that is used again.

rclpy copies a message twice while it holds the lock, each time into new memory: of a picture of 4K
some ten milliseconds, in which nobody drives. `rcl` itself is asked here instead, whose structures
have been the same in all releases of ROS 2 since there are serialized messages.
"""

from __future__ import annotations

import ctypes
from typing import Any

__all__ = ["UnlockedTake", "can_take_unlocked"]

_P, _SIZE = ctypes.c_void_p, ctypes.c_size_t
_OK = 0
# Buffers that are kept for the next messages of a topic; more are in use for a moment only.
_SPARE = 3


class _Allocator(ctypes.Structure):
    """``rcutils_allocator_t``."""

    _fields_ = (
        ("allocate", _P),
        ("deallocate", _P),
        ("reallocate", _P),
        ("zero_allocate", _P),
        ("state", _P),
    )


class _Buffer(ctypes.Structure):
    """``rcutils_uint8_array_t``: what a serialized message is in."""

    _fields_ = (("start", _P), ("length", _SIZE), ("capacity", _SIZE), ("allocator", _Allocator))


class _Info(ctypes.Structure):
    """The beginning of ``rmw_message_info_t``, and room for what follows in any release."""

    _fields_ = (
        ("source_timestamp", ctypes.c_int64),
        ("received_timestamp", ctypes.c_int64),
        ("publication_sequence_number", ctypes.c_uint64),
        ("reception_sequence_number", ctypes.c_uint64),
        ("more", ctypes.c_uint8 * 224),
    )


class _Lease:
    """A buffer that is in use for as long as this lives."""

    def __init__(self, buffer: _Buffer, spare: list[_Buffer], free: Any) -> None:  # noqa: ANN401 - a function of ctypes
        self._buffer, self._spare, self._free = buffer, spare, free

    def __del__(self) -> None:
        if len(self._spare) < _SPARE:
            self._spare.append(self._buffer)
        else:
            self._free(ctypes.byref(self._buffer))


def can_take_unlocked(handle: object) -> bool:
    """Tell whether a subscription's handle is one of rclpy in this process."""
    return type(handle).__module__.startswith("rclpy.")


class UnlockedTake:
    """Takes the messages of one subscription. On the thread that owns it."""

    def __init__(self, handle: Any) -> None:  # noqa: ANN401 - rclpy ships no types
        """Take them of rclpy's subscription with that handle.

        Raises:
            OSError: `rcl` is not found.
            AttributeError: it is not as it is known.

        """
        utils, rcl = ctypes.CDLL("librcutils.so"), ctypes.CDLL("librcl.so")
        self._handle = handle
        self._take = rcl.rcl_take_serialized_message
        self._take.argtypes = (_P, _P, _P, _P)
        self._take.restype = ctypes.c_int32
        self._forget_error = utils.rcutils_reset_error
        self._free = utils.rcutils_uint8_array_fini
        self._free.argtypes = (_P,)
        utils.rcutils_get_default_allocator.restype = _Allocator
        self._allocator = utils.rcutils_get_default_allocator()
        # Appended to by whichever thread lets a message go.
        self._spare: list[_Buffer] = []
        self._info = _Info()

    def take_message(self) -> tuple[memoryview, dict[str, int]] | None:
        """Take the next message with what rclpy tells of it, or none if there is none."""
        buffer = self._spare.pop() if self._spare else _Buffer(allocator=self._allocator)
        info = self._info
        done = self._take(self._handle.pointer, ctypes.byref(buffer), ctypes.byref(info), None)
        lease = _Lease(buffer, self._spare, self._free)
        if done != _OK:
            # There is none, most likely; what else it was the wait set would tell, too.
            self._forget_error()
            return None
        held = (ctypes.c_uint8 * buffer.length).from_address(buffer.start)
        # Whoever has a part of the message has all of this.
        held.lease = lease
        return memoryview(held).cast("B"), {
            "source_timestamp": info.source_timestamp,
            "received_timestamp": info.received_timestamp,
            "publication_sequence_number": info.publication_sequence_number,
            "reception_sequence_number": info.reception_sequence_number,
        }
