"""What other packages bring to this hub, and what of it is broken."""

from __future__ import annotations

from fastapi import APIRouter
from pydantic import BaseModel, Field

from talaia.extensions.declared import (
    AdapterExtension,
    Declared,
    DetectorExtension,
    ExtensionKeys,
    NotifierExtension,
)
from talaia.extensions.installed import installed
from talaia.extensions.shown import keys_shown

__all__ = ["ExtensionList", "ExtensionPages"]


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


class BrokenExtensionShape(BaseModel):
    """One that cannot be used, or that failed while it was used."""

    group: str
    name: str
    package: str
    problem: str


class ExtensionList(BaseModel):
    """All that is installed beside the hub."""

    extensions: list[ExtensionShape]
    broken: list[BrokenExtensionShape]


class ExtensionPages:
    """The routes of extensions."""

    def router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter()
        router.get("/api/extensions")(self.overview)
        return router

    async def overview(self) -> ExtensionList:
        """List the extensions that are installed at the hub, and what is wrong with them."""
        every = installed().every()
        return ExtensionList(
            extensions=[
                ExtensionShape(
                    group=each.group,
                    name=each.name,
                    package=each.package,
                    summary=each.declared.summary,
                    keys=_keys(each.declared),
                )
                for each in every
            ],
            broken=[BrokenExtensionShape(**each._asdict()) for each in installed().broken()],
        )


def _keys(declared: Declared) -> list[ExtensionKeyShape]:
    shape: type[ExtensionKeys] = ExtensionKeys
    secret: frozenset[str] = frozenset()
    match declared:
        case AdapterExtension():
            shape = declared.connection
        case NotifierExtension():
            shape, secret = declared.keys, declared.secret
        case DetectorExtension():
            shape = declared.keys
        case _:
            pass
    return [
        ExtensionKeyShape(**each._asdict(), secret=each.name in secret)
        for each in keys_shown(shape)
    ]
