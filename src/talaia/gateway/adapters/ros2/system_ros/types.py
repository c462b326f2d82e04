"""Types of the system's ROS 2, as its classes are used: made, filled, written and read here.

Their definitions come from the bridge, which reads them off the installed classes; messages are
written and read by them, so that no package of ROS is loaded in this process.
"""

from __future__ import annotations

import base64
import functools
from types import ModuleType, SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from talaia.gateway.adapters.ros2.type_definitions.installed_package import type_of_word
from talaia.gateway.adapters.ros2.type_definitions.message_decoder import compiled_store, decoder_of
from talaia.gateway.adapters.ros2.type_definitions.message_definition import (
    TYPE_IDS,
    FieldForm,
    MessageField,
    PartDefinition,
    TypeDefinition,
)
from talaia.gateway.adapters.ros2.type_definitions.message_encoder import (
    NUMPY_WORDS,
    MessageEncoder,
)

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["RemoteAction", "RemoteMessage", "RemoteService", "package_module"]

_FILLER = "structure_needs_at_least_one_member"
_TEXTS = ("string", "wstring")


class RemoteMessage:
    """What stands for a message's class; ``Name.Request`` and so on for parts."""

    def __init__(self, name: str, ask: Callable[..., Any]) -> None:
        """Know its name: it is described when it is first used."""
        self.name = name
        self._ask = ask

    def __call__(self, **fields: object) -> Any:  # noqa: ANN401 - a class of rosbags' making
        """Make a message with its defaults, and these fields."""
        # Anew each time: what is filled must not be another's.
        made = self.decode(self._described[1])
        for field, value in fields.items():
            setattr(made, field, value)
        return made

    def __getattr__(self, name: str) -> int:
        """Give a constant."""
        if name.isupper() and not name.startswith("_"):
            found = self.constants.get(name)
            if found is not None:
                return found
        raise AttributeError(f"{self.name} has no {name}")

    @property
    def constants(self) -> dict[str, int]:
        """Whole numbers by name."""
        return dict(self.definition.parts[self.definition.name].constants)

    @property
    def definition(self) -> TypeDefinition:
        """What it is made of."""
        return self._described[0]

    def get_fields_and_field_types(self) -> dict[str, str]:
        """Give the types of its fields, as rosidl's classes do."""
        return self._described[2][self.definition.name]

    def decode(self, data: bytes) -> Any:  # noqa: ANN401
        """Read a message."""
        return self._decode(data)

    def encode(self, message: object) -> bytes:
        """Write a message."""
        self._set_arrays(message, self.definition.name)
        return self._encoder.encode_message(message)

    @functools.cached_property
    def _described(self) -> tuple[TypeDefinition, bytes, dict[str, dict[str, str]]]:
        told = self._ask("describe", name=self.name)
        # Parts of services and actions have no file of their own, and so no name of that form.
        top = self.name.replace(".", "_")
        words = {
            top if name == self.name else name: part["fields"]
            for name, part in told["parts"].items()
        }
        parts = {
            top if name == self.name else name: PartDefinition(
                tuple(
                    MessageField(field, type_of_word(word))
                    for field, word in part["fields"].items()
                    if field != _FILLER
                ),
                part["constants"],
            )
            for name, part in told["parts"].items()
        }
        package = self.name.split("/", 1)[0]
        definition = TypeDefinition(top, parts, f"the installed package {package}").checked()
        return definition, base64.b64decode(told["empty"]), words

    @functools.cached_property
    def _decode(self) -> Callable[[bytes], object]:
        # Its messages can be asked for their fields, as rosidl's own.
        store = compiled_store(self.definition)
        for name, fields in self._described[2].items():
            told = staticmethod(lambda fields=fields: fields)
            type.__setattr__(store.types[name], "get_fields_and_field_types", told)
        return decoder_of(self.definition, proven=True, store=store)

    @functools.cached_property
    def _encoder(self) -> MessageEncoder:
        return MessageEncoder(self.definition)

    def _set_arrays(self, message: object, part: str) -> None:
        """Make arrays of lists of numbers, as the encoder wants them."""
        for field in self.definition.parts[part].fields:
            kind, value = field.type, getattr(message, field.name, None)
            if kind.base not in TYPE_IDS:
                inner = [value] if kind.form is FieldForm.ONE else value or []
                for one in inner:
                    self._set_arrays(one, kind.base)
            # The encoder takes numbers from numpy alone.
            elif kind.form is not FieldForm.ONE and kind.base not in _TEXTS:
                # rclpy has each byte of a list as bytes of length one.
                if kind.base == "byte" and isinstance(value, list):
                    value = [one[0] if isinstance(one, bytes) else one for one in value]
                array = np.asarray(value, NUMPY_WORDS.get(kind.base, kind.base))
                setattr(message, field.name, array)


class RemoteService:
    """What stands for a service's class."""

    def __init__(self, name: str, ask: Callable[..., Any]) -> None:
        """Know its name."""
        self.name = name
        self.Request = RemoteMessage(f"{name}.Request", ask)
        self.Response = RemoteMessage(f"{name}.Response", ask)


class RemoteAction:
    """What stands for an action's class."""

    def __init__(self, name: str, ask: Callable[..., Any]) -> None:
        """Know its name."""
        self.name = name
        for part in ("Goal", "Result", "Feedback"):
            setattr(self, part, RemoteMessage(f"{name}.{part}", ask))
        self.Impl = SimpleNamespace(
            SendGoalService=RemoteService(f"{name}.Impl.SendGoalService", ask),
            GetResultService=RemoteService(f"{name}.Impl.GetResultService", ask),
            FeedbackMessage=RemoteMessage(f"{name}.Impl.FeedbackMessage", ask),
        )


_KINDS: dict[str, Callable[..., Any]] = {
    "msg": RemoteMessage,
    "srv": RemoteService,
    "action": RemoteAction,
}


def package_module(package: str, kind: str, ask: Callable[..., Any]) -> ModuleType:
    """Make the module ``package.msg`` (or ``srv``, ``action``), which finds types by name."""
    module = ModuleType(f"{package}.{kind}")

    @functools.cache
    def find(name: str) -> Any:  # noqa: ANN401
        full = f"{package}/{kind}/{name}"
        # Python asks modules for names of its own.
        if name.startswith("_") or not ask("knows", name=full):
            raise AttributeError(f"the system's ROS 2 has no {full}")
        return _KINDS[kind](full, ask)

    module.__dict__["__getattr__"] = find
    return module
