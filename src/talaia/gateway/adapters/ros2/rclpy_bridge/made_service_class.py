"""Service classes of types that are not installed; for the process of `service_caller` alone.

Unlike a subscription, a call goes through objects: the middleware calls a serializer for the
request while it holds its writer's lock. Ours is Python's, which waits for the interpreter's lock:
in a process with several threads that can hang both for good. So none is ever made in a gateway's
own process, nor in a bridge's. The objects hold the bytes of a message, with the header of CDR.
"""

from __future__ import annotations

import ctypes
import functools
from typing import TYPE_CHECKING, Any

from .made_message_class import CannotMakeClass
from .rosidl_structs import (
    Callbacks,
    Support,
    address_of,
    capsule_of,
    introspect_if_wanted,
    keep_for_ever,
    string_support,
    tell_hash,
)

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["MadeMessage", "made_service"]

_P = ctypes.c_void_p
_HEAD = b"\x00\x01\x00\x00"
_SERIALIZE = ctypes.CFUNCTYPE(ctypes.c_bool, _P, _P)
_SIZE = ctypes.CFUNCTYPE(ctypes.c_uint32, _P)
_MOST = ctypes.CFUNCTYPE(ctypes.c_size_t, ctypes.POINTER(ctypes.c_char))
_CREATE = ctypes.CFUNCTYPE(_P)
_DESTROY = ctypes.CFUNCTYPE(None, _P)
_FROM_PYTHON = ctypes.CFUNCTYPE(ctypes.c_bool, ctypes.py_object, _P)
_TO_PYTHON = ctypes.CFUNCTYPE(ctypes.py_object, _P)
# Names of fastcdr's functions, of version 2 and of version 1 (Humble).
_WRITE = (
    "_ZN8eprosima7fastcdr3Cdr15serialize_arrayEPKcm",
    "_ZN8eprosima7fastcdr3Cdr14serializeArrayEPKcm",
)
_BEGIN = (
    "_ZN8eprosima7fastcdr3Cdr18get_buffer_pointerEv",
    "_ZN8eprosima7fastcdr3Cdr16getBufferPointerEv",
)
_NEW_BUFFER = ("_ZN8eprosima7fastcdr10FastBufferC1EPcm",)
_NEW_CDR = (
    "_ZN8eprosima7fastcdr3CdrC1ERNS0_10FastBufferENS1_10EndiannessENS0_10CdrVersionE",
    "_ZN8eprosima7fastcdr3CdrC1ERNS0_10FastBufferENS1_10EndiannessENS1_7CdrTypeE",
)
# A size that no pointer has.
_MARK = 51
# What a message is in memory: a few bytes whose address names it; its bytes stand here.
_bodies: dict[int, bytes] = {}
_blocks: dict[int, object] = {}


class _ServiceCallbacks(ctypes.Structure):
    """``service_type_support_callbacks_t`` of rosidl_typesupport_fastrtps."""

    _fields_ = (
        ("namespace", ctypes.c_char_p),
        ("name", ctypes.c_char_p),
        ("request", _P),
        ("response", _P),
    )


class _ServiceSupport(ctypes.Structure):
    """``rosidl_service_type_support_t``; Humble's ends with ``find``."""

    _fields_ = (
        ("identifier", _P),
        ("data", _P),
        ("find", _P),
        ("request", _P),
        ("response", _P),
        ("event", _P),
        ("create_event", _P),
        ("destroy_event", _P),
        ("hash", _P),
        ("description", _P),
        ("sources", _P),
    )


class MadeMessage:
    """The bytes of a request or a response, with the header of CDR."""

    __slots__ = ("raw",)

    def __init__(self, raw: bytes = _HEAD) -> None:
        """Hold them."""
        self.raw = raw


@functools.lru_cache(maxsize=None)  # noqa: UP033 - Python 3.8
def made_service(type_name: str, type_hash: str) -> Any:  # noqa: ANN401 - as rosidl's classes
    """Make the class of ``package/srv/Name``, with its ``Request`` and ``Response``.

    Raises:
        CannotMakeClass: ROS's libraries are not as they are known.

    """
    package, middle, name = type_name.split("/")
    try:
        _cdr_functions()
        runtime = ctypes.CDLL("librosidl_runtime_c.so")
        parts = {
            ending: _message_support(f"{package}/{middle}/{name}_{ending}")
            for ending in ("Request", "Response", "Event")
        }
        data = keep_for_ever(
            _ServiceCallbacks(
                f"{package}::{middle}".encode(),
                name.encode(),
                ctypes.addressof(parts["Request"]),
                ctypes.addressof(parts["Response"]),
            )
        )
        support = keep_for_ever(
            _ServiceSupport(
                string_support().identifier,
                ctypes.addressof(data),
                address_of(runtime.get_service_typesupport_handle_function),
                *(ctypes.addressof(part) for part in parts.values()),
            )
        )
        tell_hash(support, type_name, type_hash)
    except (OSError, AttributeError, ValueError) as error:
        raise CannotMakeClass(f"no class can be made of {type_name}: {error}") from error
    meta = type(
        f"Metaclass_{name}", (type,), {"_TYPE_SUPPORT": capsule_of(ctypes.addressof(support))}
    )
    members = {
        ending: _message_class(f"{name}_{ending}", parts[ending])
        for ending in ("Request", "Response")
    }
    return meta(name, (), members)


def _message_support(type_name: str) -> Support:
    package, middle, name = type_name.split("/")
    callbacks = keep_for_ever(
        Callbacks(
            f"{package}::{middle}".encode(),
            name.encode(),
            _c_address(_SERIALIZE, _serialize_body),
            _c_address(_SERIALIZE, _deserialize_body),
            _c_address(_SIZE, _body_size),
            _c_address(_MOST, _most_size),
            None,
        )
    )
    model = string_support()
    support: Support = keep_for_ever(
        Support(model.identifier, ctypes.addressof(callbacks), model.find)
    )
    tell_hash(support, type_name, "")
    introspect_if_wanted(support, callbacks)
    return support


def _message_class(name: str, support: Support) -> Any:  # noqa: ANN401
    def to_python(where: int) -> object:
        return kind(_bodies.get(where, _HEAD))

    parts = {
        "_TYPE_SUPPORT": capsule_of(ctypes.addressof(support)),
        "_CREATE_ROS_MESSAGE": capsule_of(_c_address(_CREATE, _create_message)),
        "_DESTROY_ROS_MESSAGE": capsule_of(_c_address(_DESTROY, _destroy_message)),
        "_CONVERT_FROM_PY": capsule_of(_c_address(_FROM_PYTHON, _from_python)),
        "_CONVERT_TO_PY": capsule_of(_c_address(_TO_PYTHON, to_python)),
    }
    kind: Any = type(f"Metaclass_{name}", (type,), parts)(name, (MadeMessage,), {"__slots__": ()})
    return kind


def _c_address(kind: Any, function: Callable[..., Any]) -> int | None:  # noqa: ANN401
    """Give the address under which C calls a function."""
    return address_of(keep_for_ever(kind(function)))


# ── what the middleware calls; an exception must not leave any of these ──


def _create_message() -> int:
    block = ctypes.create_string_buffer(16)
    where = ctypes.addressof(block)
    _blocks[where] = block
    _bodies[where] = b""
    return where


def _destroy_message(where: int) -> None:
    _bodies.pop(where, None)
    _blocks.pop(where, None)


def _from_python(message: MadeMessage, where: int) -> bool:
    _bodies[where] = message.raw
    return True


def _serialize_body(where: int, cdr: int) -> bool:
    try:
        body = _bodies[where]
        # The middleware has written the header, and `_size` has seen to the room.
        start = ctypes.cast(ctypes.c_char_p(body), _P).value or 0
        _cdr_functions()[0](cdr, start + len(_HEAD), len(body) - len(_HEAD))
    except Exception:  # noqa: BLE001 - C++ would end the process
        return False
    return True


def _deserialize_body(cdr: int, where: int) -> bool:
    try:
        _, begin, buffer_at, size_at = _cdr_functions()
        buffer = ctypes.c_uint64.from_address(cdr + 8 * buffer_at).value
        size = ctypes.c_uint64.from_address(buffer + 8 * size_at).value
        _bodies[where] = ctypes.string_at(begin(cdr), size)
    except Exception:  # noqa: BLE001 - C++ would end the process
        return False
    return True


def _body_size(where: int) -> int:
    # The caller adds the header.
    return max(0, len(_bodies.get(where, b"")) - len(_HEAD))


def _most_size(bounds: Any) -> int:  # noqa: ANN401 - a pointer to a char
    # Of no bound.
    bounds[0] = 0
    return 0


@functools.lru_cache(maxsize=None)  # noqa: UP033 - Python 3.8
def _cdr_functions() -> tuple[Any, Any, int, int]:
    """Find how to write bytes with a ``Cdr``, and to read its whole buffer.

    Returns:
        what writes an array of char; what gives the begin of a buffer; which word of a ``Cdr`` is
        its buffer, and which of a ``FastBuffer`` its size: found by making one of each.

    """
    library = ctypes.CDLL("libfastcdr.so")
    write = _find_symbol(library, _WRITE)
    write.argtypes, write.restype = [_P, _P, ctypes.c_size_t], _P
    begin = _find_symbol(library, _BEGIN)
    begin.argtypes, begin.restype = [_P], _P
    new_buffer, new_cdr = _find_symbol(library, _NEW_BUFFER), _find_symbol(library, _NEW_CDR)
    new_buffer.argtypes, new_buffer.restype = [_P, _P, ctypes.c_size_t], None
    new_cdr.argtypes, new_cdr.restype = [_P, _P, ctypes.c_int, ctypes.c_int], None
    data = keep_for_ever(ctypes.create_string_buffer(64))
    buffer = keep_for_ever((ctypes.c_uint64 * 16)())
    reader = keep_for_ever((ctypes.c_uint64 * 256)())
    new_buffer(ctypes.addressof(buffer), ctypes.addressof(data), _MARK)
    size_at = list(buffer).index(_MARK)
    new_cdr(ctypes.addressof(reader), ctypes.addressof(buffer), 1, 1)
    buffer_at = list(reader).index(ctypes.addressof(buffer))
    if begin(ctypes.addressof(reader)) != ctypes.addressof(data):
        raise ValueError("fastcdr's Cdr is not as it is known")
    return write, begin, buffer_at, size_at


def _find_symbol(library: ctypes.CDLL, names: tuple[str, ...]) -> Any:  # noqa: ANN401
    for name in names:
        found = getattr(library, name, None)
        if found is not None:
            return found
    raise AttributeError(f"fastcdr has no {names[0]}")
