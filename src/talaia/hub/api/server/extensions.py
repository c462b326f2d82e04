"""What other packages bring to this hub, and what of it is broken."""

from __future__ import annotations

from fastapi import APIRouter

from talaia.extensions.declared import (
    AdapterExtension,
    Declared,
    DetectorExtension,
    ExtensionKeys,
    NotifierExtension,
)
from talaia.extensions.installed import installed
from talaia.extensions.shown import keys_shown
from talaia.hub.api.schemas.extension_schemas import (
    BrokenExtensionShape,
    ExtensionKeyShape,
    ExtensionList,
    ExtensionShape,
)

__all__ = ["ExtensionPages"]


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
                    group=extension.group,
                    name=extension.name,
                    package=extension.package,
                    summary=extension.declared.summary,
                    keys=_keys(extension.declared),
                )
                for extension in every
            ],
            broken=[
                BrokenExtensionShape(**extension._asdict()) for extension in installed().broken()
            ],
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
        ExtensionKeyShape(**key._asdict(), secret=key.name in secret) for key in keys_shown(shape)
    ]
