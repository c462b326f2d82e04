"""Message classes of types that are not installed, by which raw messages are subscribed to.

rclpy wants a class for a subscription, and the middleware takes from it nothing but the type's
name and hash as long as messages are taken as bytes. So the class of ``std_msgs/msg/String`` is
copied at the C level and gets another name: the functions in it are never called for messages.
Nothing is ever published with such a class: its objects hold nothing.

Only ``rmw_fastrtps_cpp``: other middlewares ask for more than a name. The structs are those of
rosidl from Humble to Rolling, where they only grew at their ends. rcl keeps bare pointers, so what
is made is kept for ever.
"""

from __future__ import annotations

import ctypes
import functools
import hashlib
from typing import Any

import rclpy
from std_msgs.msg import String

from talaia.gateway.errors import GatewayError

__all__ = ["CannotMakeTypes", "forget_error", "is_made", "made_class", "problem_here"]

_MIDDLEWARE = "rmw_fastrtps_cpp"
_STRING_SUPPORT = (
    "rosidl_typesupport_fastrtps_c__get_message_type_support_handle__std_msgs__msg__String"
)
# What rclpy wants a class to have, beside its type support.
_FOR_OBJECTS = (
    "_CREATE_ROS_MESSAGE",
    "_DESTROY_ROS_MESSAGE",
    "_CONVERT_FROM_PY",
    "_CONVERT_TO_PY",
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


class CannotMakeTypes(GatewayError):
    """Classes for types that are not installed cannot be made here."""


class _Made:
    """What all made classes are."""


class _Callbacks(ctypes.Structure):
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


class _Support(ctypes.Structure):
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


def problem_here() -> str:
    """Say why no classes can be made with the middleware in use; empty where they can."""
    used = rclpy.get_rmw_implementation_identifier()
    if used != _MIDDLEWARE:
        return f"the middleware is {used}, and only {_MIDDLEWARE} takes types by name"
    return ""


@functools.cache
def made_class(type_name: str, type_hash: str) -> Any:  # noqa: ANN401 - as rosidl's classes
    """Make the class of ``package/msg/Name``; the same one for the same type.

    Args:
        type_name: which.
        type_hash: what its publisher says, ``RIHS01_…``; empty where nobody says it.

    Raises:
        CannotMakeTypes: ROS's libraries are not as they are known.

    """
    try:
        support = _support_of(type_name, type_hash)
    except (OSError, AttributeError, ValueError) as error:
        raise CannotMakeTypes(f"no class can be made of {type_name}: {error}") from error
    meta = type(String)
    if vars(meta)["_TYPE_SUPPORT"] is None:
        meta.__import_type_support__()
    # Those for objects are never called: nothing is taken or published but bytes.
    parts = {name: vars(meta)[name] for name in _FOR_OBJECTS}
    parts["_TYPE_SUPPORT"] = _capsule(ctypes.addressof(support))
    name = type_name.rsplit("/", 1)[1]
    return type(f"Metaclass_{name}", (type,), parts)(name, (_Made,), {})


def is_made(kind: Any) -> bool:  # noqa: ANN401
    """Tell whether a message's class is one that was made here."""
    return issubclass(kind, _Made)


def forget_error() -> None:
    """Forget the error that the middleware leaves after it has made something of such a class.

    From Kilted on it looks for an introspection of the type, finds none, and goes on; rclpy would
    raise what it left behind at the next opportunity.
    """
    ctypes.CDLL("librcutils.so").rcutils_reset_error()


def _support_of(type_name: str, type_hash: str) -> _Support:
    package, middle, name = type_name.split("/")
    model = _string_support()
    like = ctypes.cast(model.data, ctypes.POINTER(_Callbacks)).contents
    callbacks = _kept(
        _Callbacks(
            f"{package}::{middle}".encode(),
            name.encode(),
            like.serialize,
            like.deserialize,
            like.size,
            like.most,
            None,
        )
    )
    support: _Support = _kept(_Support(model.identifier, ctypes.addressof(callbacks), model.find))
    _tell_hash(support, type_name, type_hash)
    if _wants_introspection():
        _introspect(support, callbacks)
    return support


@functools.cache
def _string_support() -> _Support:
    library = ctypes.CDLL("libstd_msgs__rosidl_typesupport_fastrtps_c.so")
    get = getattr(library, _STRING_SUPPORT)
    get.restype = ctypes.POINTER(_Support)
    found = get().contents
    assert isinstance(found, _Support)  # noqa: S101 - the pointer's type
    return found


def _tell_hash(support: _Support, type_name: str, type_hash: str) -> None:
    """Let the type's hash and an empty description be told, where this ROS asks for them."""
    runtime = ctypes.CDLL("librosidl_runtime_c.so")
    prefix = "rosidl_runtime_c__type_description__"
    try:
        new_description = getattr(runtime, f"{prefix}TypeDescription__create")
        new_sources = getattr(runtime, f"{prefix}TypeSource__Sequence__create")
    except AttributeError:
        # Humble's asks for none.
        return
    told = _kept(_Hash(version=_HASH_VERSION))
    if type_hash.startswith(_PREFIX):
        told.value[:] = bytes.fromhex(type_hash.removeprefix(_PREFIX))
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
        _address(_kept(_GETTER(lambda _, address=address: address))) for address in addresses
    )


@functools.cache
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


def _introspect(support: _Support, callbacks: _Callbacks) -> None:
    """Give a support the introspection of a message without members."""
    library = ctypes.CDLL("librosidl_typesupport_introspection_c.so")
    symbol = "rosidl_typesupport_introspection_c__identifier"
    identifier = _P.in_dll(library, symbol).value
    members = _kept(_Members(callbacks.namespace, callbacks.name, 0, 16))
    inner = _kept(
        _Support(
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
    support.find = _address(_kept(_FINDER(lambda _, wanted: kinds.get(wanted))))


def _capsule(address: int) -> object:
    new = ctypes.pythonapi.PyCapsule_New
    new.restype, new.argtypes = ctypes.py_object, [_P, ctypes.c_char_p, _P]
    capsule: object = new(address, None, None)
    return capsule


def _address(function: Any) -> int | None:  # noqa: ANN401 - a pointer to a C function
    return ctypes.cast(function, _P).value


def _kept(thing: Any) -> Any:  # noqa: ANN401
    _KEPT.append(thing)
    return thing
