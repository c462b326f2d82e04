"""What rosidl's type supports look like in C, and how one is made and told about.

The structs are those from Humble to Rolling, where they only grew at their ends. rcl keeps bare
pointers, so what is made is kept for ever. Also used by a bridge's own Python.
"""

from __future__ import annotations

import ctypes
import functools
import hashlib
from typing import Any

__all__ = [
    "Callbacks",
    "Support",
    "address_of",
    "capsule_of",
    "introspect_if_wanted",
    "keep_for_ever",
    "string_support",
    "tell_hash",
]

_STRING_SUPPORT = (
    "rosidl_typesupport_fastrtps_c__get_message_type_support_handle__std_msgs__msg__String"
)
_HASH_VERSION = 1
_PREFIX = "RIHS01_"
# rcl keeps bare pointers to all of it.
_KEPT: list[object] = []
_P = ctypes.c_void_p
# What a function that tells the hash, or a description, looks like.
_GETTER = ctypes.CFUNCTYPE(_P, _P)
# How a support is asked for another of its kinds.
_FINDER = ctypes.CFUNCTYPE(_P, _P, ctypes.c_char_p)


class Callbacks(ctypes.Structure):
    """``message_type_support_callbacks_t`` of rosidl_typesupport_fastrtps."""

    _fields_ = (
        ("namespace", ctypes.c_char_p),
        ("name", ctypes.c_char_p),
        ("serialize", _P),
        ("deserialize", _P),
        ("size", _P),
        ("most", _P),
        ("keys", _P),
    )


class Support(ctypes.Structure):
    """``rosidl_message_type_support_t``; the last three are not in Humble's."""

    _fields_ = (
        ("identifier", _P),
        ("data", _P),
        ("find", _P),
        ("hash", _P),
        ("description", _P),
        ("sources", _P),
    )


class _Hash(ctypes.Structure):
    """``rosidl_type_hash_t``."""

    _fields_ = (("version", ctypes.c_uint8), ("value", ctypes.c_uint8 * 32))


class _Members(ctypes.Structure):
    """``MessageMembers`` of rosidl_typesupport_introspection_c, of a message without any."""

    _fields_ = (
        ("namespace", ctypes.c_char_p),
        ("name", ctypes.c_char_p),
        ("count", ctypes.c_uint64),
        ("size", ctypes.c_size_t),
        ("rest", ctypes.c_uint64 * 8),
    )


@functools.lru_cache(maxsize=None)  # noqa: UP033 - Python 3.8
def string_support() -> Support:
    """Give ROS's own type support of ``std_msgs/msg/String``."""
    library = ctypes.CDLL("libstd_msgs__rosidl_typesupport_fastrtps_c.so")
    get = getattr(library, _STRING_SUPPORT)
    get.restype = ctypes.POINTER(Support)
    found = get().contents
    assert isinstance(found, Support)  # noqa: S101 - the pointer's type
    return found


def tell_hash(support: Any, type_name: str, type_hash: str) -> None:  # noqa: ANN401 - of either kind
    """Let the type's hash and an empty description be told, where this ROS asks for them."""
    runtime = ctypes.CDLL("librosidl_runtime_c.so")
    prefix = "rosidl_runtime_c__type_description__"
    try:
        new_description = getattr(runtime, f"{prefix}TypeDescription__create")
        new_sources = getattr(runtime, f"{prefix}TypeSource__Sequence__create")
    except AttributeError:
        # Humble's asks for none.
        return
    told = keep_for_ever(_Hash(version=_HASH_VERSION))
    if type_hash.startswith(_PREFIX):
        told.value[:] = bytes.fromhex(type_hash[len(_PREFIX) :])
    else:
        # Without any the middleware complains, and it only informs: names decide.
        told.value[:] = hashlib.sha256(type_name.encode()).digest()
    new_description.restype = new_sources.restype = _P
    new_sources.argtypes = [ctypes.c_size_t]
    assign = runtime.rosidl_runtime_c__String__assign
    assign.argtypes = [_P, ctypes.c_char_p]
    description, sources = new_description(), new_sources(0)
    # The name is the first member of a description.
    assign(description, type_name.encode())
    addresses = (ctypes.addressof(told), description, sources)
    support.hash, support.description, support.sources = (
        address_of(keep_for_ever(_GETTER(lambda _, address=address: address)))
        for address in addresses
    )


@functools.lru_cache(maxsize=None)  # noqa: UP033 - Python 3.8
def _wants_introspection() -> bool:
    """Tell whether this ROS makes nothing of a type without an introspection.

    So it is up to Jazzy, with Fast DDS 2. With Fast DDS 3 (Kilted) an empty one would be sent to
    publishers, and match none.
    """
    try:
        ctypes.CDLL("libfastdds.so")
    except OSError:
        return True
    return False


def introspect_if_wanted(support: Support, callbacks: Callbacks) -> None:
    """Give a support the introspection of a message without members, where this ROS wants one."""
    if not _wants_introspection():
        return
    library = ctypes.CDLL("librosidl_typesupport_introspection_c.so")
    symbol = "rosidl_typesupport_introspection_c__identifier"
    identifier = _P.in_dll(library, symbol).value
    members = keep_for_ever(_Members(callbacks.namespace, callbacks.name, 0, 16))
    inner = keep_for_ever(
        Support(
            identifier,
            ctypes.addressof(members),
            support.find,
            support.hash,
            support.description,
            support.sources,
        )
    )
    if identifier is None or support.identifier is None:
        raise ValueError("ROS's type supports have no names")
    kinds = {
        ctypes.string_at(support.identifier): ctypes.addressof(support),
        ctypes.string_at(identifier): ctypes.addressof(inner),
    }
    support.find = address_of(keep_for_ever(_FINDER(lambda _, wanted: kinds.get(wanted))))


def capsule_of(address: int | None) -> object:
    """Give a pointer as rclpy takes it."""
    new = ctypes.pythonapi.PyCapsule_New
    new.restype, new.argtypes = ctypes.py_object, [_P, ctypes.c_char_p, _P]
    capsule: object = new(address, None, None)
    return capsule


def address_of(function: Any) -> int | None:  # noqa: ANN401 - a pointer to a C function
    """Give where a C function is."""
    return ctypes.cast(function, _P).value


def keep_for_ever(thing: Any) -> Any:  # noqa: ANN401
    """Keep what C points at, and give it."""
    _KEPT.append(thing)
    return thing
