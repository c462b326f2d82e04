"""What FastAPI finds out about a route, found out once for all hubs of a process.

Most of what it takes to start a hub is to read the signatures of its routes and to build what
checks their parameters: the same for every hub. The first hub of a process builds all of it.
"""

from __future__ import annotations

import dataclasses
import functools
import inspect

import fastapi.dependencies.models
import fastapi.routing
import pytest
from fastapi.dependencies.models import Dependant
from fastapi.dependencies.utils import get_dependant, get_typed_return_annotation

# Whether a function is a coroutine's, a generator's: asked of each route, forgotten with each hub.
_KINDS = (
    "_is_gen_callable_cached",
    "_is_async_gen_callable_cached",
    "_is_coroutine_callable_cached",
)
_LISTS = [field.name for field in dataclasses.fields(Dependant) if field.default_factory is list]


class _Nobody:
    """Stands for the object that a method belongs to: what is kept must hold no hub."""


_NOBODY = _Nobody()


@functools.cache
def _kept_dependant(path: str, function, scope: str | None) -> Dependant:
    return get_dependant(path=path, call=function.__get__(_NOBODY), scope=scope)


@functools.cache
def _kept_annotation(function):
    return get_typed_return_annotation(function)


def _dependant_of(*, path: str, call, scope: str | None = None) -> Dependant:
    # A function inside another belongs to one hub.
    if not inspect.ismethod(call):
        return get_dependant(path=path, call=call, scope=scope)
    kept = _kept_dependant(path, call.__func__, scope)
    # The lists are added to.
    own = {name: list(getattr(kept, name)) for name in _LISTS}
    return dataclasses.replace(kept, call=call, **own)


def _annotation_of(call):
    return (_kept_annotation if inspect.ismethod(call) else get_typed_return_annotation)(
        getattr(call, "__func__", call)
    )


def _kept_judgement(judge):
    """Answer of a method what is true of its function, without asking again."""
    kept: dict[object, bool] = {}

    def answer(identity) -> bool:
        call = identity.call
        if not inspect.ismethod(call):
            return judge(identity)
        if (function := call.__func__) not in kept:
            kept[function] = judge(identity)
        return kept[function]

    # By this all that is remembered of hubs is forgotten; functions are no hub's.
    answer.cache_clear = judge.cache_clear
    return answer


@pytest.fixture(scope="session", autouse=True)
def _routes_are_read_once():
    """Spare half of what it takes to start a hub."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fastapi.routing, "get_dependant", _dependant_of)
        patch.setattr(fastapi.routing, "get_typed_return_annotation", _annotation_of)
        for name in ("create_model_field", "compile_path"):
            patch.setattr(fastapi.routing, name, functools.cache(getattr(fastapi.routing, name)))
        models = fastapi.dependencies.models
        for name in _KINDS:
            patch.setattr(models, name, _kept_judgement(getattr(models, name)))
        yield
