"""Definitions of services, and the hash by which a robot confirms one. Pure."""

from __future__ import annotations

from typing import NamedTuple

from talaia.gateway.adapters.ros2.type_definitions.message_definition import (
    FieldForm,
    FieldType,
    MessageField,
    PartDefinition,
    TypeDefinition,
    type_hash,
)

__all__ = ["EVENT_INFO", "ServiceDefinition", "service_hash"]

# What an event of a service (service introspection) begins with.
EVENT_INFO = "service_msgs/msg/ServiceEventInfo"


class ServiceDefinition(NamedTuple):
    """A service ``package/srv/Name``: what is asked, and what is answered."""

    name: str
    request: TypeDefinition
    response: TypeDefinition


def service_hash(service: ServiceDefinition, info: TypeDefinition) -> str:
    """Give the hash of a service's type (REP-2011).

    Args:
        service: both parts checked.
        info: the definition of `EVENT_INFO`, which each service's event has in it.

    """
    name = service.name
    parts = {**service.request.parts, **service.response.parts, **info.parts}
    parts[f"{name}_Event"] = PartDefinition(
        (
            MessageField("info", FieldType(EVENT_INFO)),
            MessageField("request", FieldType(f"{name}_Request", FieldForm.BOUNDED, 1)),
            MessageField("response", FieldType(f"{name}_Response", FieldForm.BOUNDED, 1)),
        ),
        {},
    )
    parts[name] = PartDefinition(
        (
            MessageField("request_message", FieldType(f"{name}_Request")),
            MessageField("response_message", FieldType(f"{name}_Response")),
            MessageField("event_message", FieldType(f"{name}_Event")),
        ),
        {},
    )
    return type_hash(TypeDefinition(name, parts).checked())
