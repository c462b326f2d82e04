"""What the routes of extensions give."""

from __future__ import annotations

from pydantic import BaseModel, Field

from talaia.extensions.installed import BrokenExtension  # noqa: TC001 - pydantic reads it

__all__ = ["ExtensionKeyShape", "ExtensionList", "ExtensionShape"]


class ExtensionKeyShape(BaseModel):
    """One key that an extension takes."""

    name: str
    type: str = Field(description="what it may be, in words")
    about: str = Field(description="what it means")
    required: bool
    default: str = Field(description="what stands where it is not given")
    secret: bool = Field(description="it is typed like a password")


class ExtensionShape(BaseModel):
    """One extension that can be used."""

    group: str = Field(description="of its entry point: ``talaia.notifiers``")
    name: str
    package: str = Field(description="the package that brings it, with its version")
    summary: str
    keys: list[ExtensionKeyShape]


class ExtensionList(BaseModel):
    """All that is installed beside the hub."""

    extensions: list[ExtensionShape]
    broken: list[BrokenExtension]
