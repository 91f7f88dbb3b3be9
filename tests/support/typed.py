"""Results made by hand, by type: what a test leaves out for brevity is filled in."""

import pickle
from collections.abc import Mapping
from functools import lru_cache
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError

from assessment.results.schema import Results, with_messages
from assessment.results.schema.part import Part
from assessment.results.summary import summary_of

Kind = TypeVar("Kind", bound=Part)

NOTHING: dict[Any, Any] = {float: 0.0, int: 0, str: "", bool: False}


def typed(content: Mapping[str, Any]) -> Results:
    """Return plain results by type and their summary; keys that have to be there and are not stand for nothing."""
    return _typed(pickle.dumps(dict(content)))


@lru_cache(maxsize=32)
def _typed(pickled: bytes) -> Results:
    content = with_messages(pickle.loads(pickled))
    try:
        results = Results.model_validate(content)
    except ValidationError:
        results = Results.model_validate(filled(Results, content))
    return results.replace(summary=summary_of(results))


def made(kind: type[Kind], content: Mapping[str, Any] | None = None) -> Kind:
    """Return a part of the results with this content; keys that have to be there and are not stand for nothing."""
    return kind.model_validate(filled(kind, content))


def filled(kind: Any, value: Any = None) -> Any:
    """Return a value of a kind, its tables with all the keys that have to be there."""
    origin, inner = get_origin(kind), get_args(kind)
    if origin in (Union, UnionType):
        if value is None and NoneType in inner:
            return None
        return filled(next(each for each in inner if each is not NoneType), value)
    if origin is Annotated:
        return filled(inner[0], value)
    if origin is list:
        return [filled(inner[0], each) for each in value or []]
    if origin is dict:
        return {name: filled(inner[1], each) for name, each in (value or {}).items()}
    if origin is Literal:
        return inner[0] if value is None else value
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        if isinstance(value, kind):
            return value
        found = dict(value or {})
        for name, field in kind.model_fields.items():
            key = field.alias or name
            if field.is_required() or key in found:
                found[key] = filled(field.annotation, found.get(key))
        return found
    return NOTHING.get(kind) if value is None else value
