"""Roles and their permissions, as an admin makes and changes them."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING

from fastapi import APIRouter, Request

from talaia.hub.api.access import address_of, number_of, who_of
from talaia.hub.api.accounts.sign_in import permissions_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.account_schemas import FactorNeed, RoleAsk, RoleList, RoleShape
from talaia.hub.auth.passwords import check_name
from talaia.hub.auth.permissions import Permission, Right
from talaia.hub.errors import NameTaken, RoleInUse, SeededRole, UnknownRole, WeakPassword

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from talaia.hub.api.schemas.common import PermissionShape
    from talaia.hub.live.pages.session_registry import SocketSessions
    from talaia.hub.store.accounts.roles import Role, Roles
    from talaia.hub.store.audit import Audit

__all__ = ["RolePages", "in_words", "read_permissions"]


class RolePages:
    """The routes of roles."""

    def __init__(self, roles: Roles, seats: SocketSessions, audit: Audit) -> None:
        """Work on ``roles``; open sockets follow each change at once."""
        self._roles = roles
        self._seats = seats
        self._audit = audit

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/roles")(self.overview)
        router.post("/api/roles")(self.add)
        router.put("/api/roles/{role}")(self.change)
        router.delete("/api/roles/{role}", status_code=204)(self.remove)
        router.put("/api/roles/{role}/factor")(self.require_factor)
        return router

    async def overview(self) -> RoleList:
        """List every role with its permissions."""
        return RoleList(roles=[_role_schema(role) for role in await self._roles.list_roles()])

    async def add(self, asked: RoleAsk, request: Request) -> RoleShape:
        """Make a role."""
        # Of sites and devices that may not be there yet: a permission needs no description.
        given = read_permissions(asked.permissions)
        with _translate_refusals():
            check_name(asked.name)
            made = await self._roles.find_role(await self._roles.add_role(asked.name, given))
        self._append_record(request, "role added", f"{asked.name}: {in_words(given)}")
        return _role_schema(made)

    async def change(self, role: str, asked: RoleAsk, request: Request) -> RoleShape:
        """Give a role another name or other permissions; open pages follow at once."""
        number, given = number_of(role, "role"), read_permissions(asked.permissions)
        with _translate_refusals():
            check_name(asked.name)
            before = await self._roles.find_role(number)
            await self._roles.change_role(number, asked.name, given)
            after = await self._roles.find_role(number)
        # Whoever drives by this role loses it now, not at the next check.
        await self._seats.follow()
        # Both in the log: it must say what a role could do at any time.
        was = in_words(before.grants.permissions)
        self._append_record(
            request,
            "role changed",
            f"{before.name}: {was} -> {asked.name}: {in_words(given)}",
        )
        return _role_schema(after)

    async def require_factor(self, role: str, asked: FactorNeed, request: Request) -> RoleShape:
        """Say whether a role requires a second factor.

        Who has the role and no factor sets one up before anything else, also on open pages.
        """
        number, who = number_of(role, "role"), who_of(request)
        with _translate_refusals():
            found = await self._roles.find_role(number)
            # Whoever switches it on for themselves has shown that they can sign in with one; so
            # there is always somebody who can take it back.
            if asked.required and found.name == who.role and not who.factor:
                raise ApiProblem(
                    409, "no_factor", "this is your own role: set up your own second factor first"
                )
            await self._roles.require_factor(number, required=asked.required)
            after = await self._roles.find_role(number)
        await self._seats.follow()
        if found.factor_required != asked.required:
            kind = "required" if asked.required else "no longer required"
            self._append_record(request, f"second factor {kind}", f"role {found.name}")
        return _role_schema(after)

    async def remove(self, role: str, request: Request) -> None:
        """Remove a role that nobody has."""
        with _translate_refusals():
            name = await self._roles.remove_role(number_of(role, "role"))
        self._append_record(request, "role removed", name)

    def _append_record(self, request: Request, kind: str, message: str) -> None:
        who = who_of(request).name
        self._audit.append_record(kind, who=who, address=address_of(request), message=message)


def read_permissions(asked: Iterable[PermissionShape]) -> list[Permission]:
    """Read permissions, each once."""
    found = (
        Permission(Right(permission.right), permission.site, permission.device)
        for permission in asked
    )
    return list(dict.fromkeys(found))


def in_words(given: Iterable[Permission]) -> str:
    """Write permissions for the audit log: ``use agv/base, view agv/*``."""
    said = sorted(
        f"{permission.right.value} {permission.site}/{permission.device}" for permission in given
    )
    return ", ".join(said) or "no permission"


@contextmanager
def _translate_refusals() -> Iterator[None]:
    """Answer what the roles refuse."""
    try:
        yield
    except WeakPassword as error:
        raise ApiProblem(422, "invalid", str(error)) from error
    except UnknownRole as error:
        raise ApiProblem(404, "unknown", str(error)) from error
    except NameTaken as error:
        raise ApiProblem(409, "taken", str(error)) from error
    except SeededRole as error:
        raise ApiProblem(409, "seeded", str(error)) from error
    except RoleInUse as error:
        raise ApiProblem(409, "in_use", str(error)) from error


def _role_schema(role: Role) -> RoleShape:
    return RoleShape(
        id=str(role.id),
        name=role.name,
        seeded=role.seeded,
        people=role.people,
        factor_required=role.factor_required,
        permissions=permissions_of(role.grants),
    )
