"""What every part of results.json is made of: exact types, finite numbers, no key that is not described."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Self, TypeVar

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    ValidationError,
    ValidatorFunctionWrapHandler,
    WrapValidator,
)

Name = TypeVar("Name")
Value = TypeVar("Value")

Point = list[float]
Configuration = list[list[float]]
"""Of each block: displacement x, z (m) and rotation (rad) from the drawing."""


def _kept(value: Any, checked: ValidatorFunctionWrapHandler) -> Any:
    """Return a string as it is: of a message (a kind of string) pydantic makes a plain one."""
    return value if isinstance(value, str) else checked(value)


Sentence = Annotated[str, WrapValidator(_kept)]
"""A sentence for people; a message keeps what it is made of."""


class Part(BaseModel):
    """A table of results.json. A missing optional key was not asked for; null was asked for and not reached.

    Both are None as attributes; where a reader is told which, `cells` of assessment/results/table.py tells them apart.
    """

    model_config = ConfigDict(
        strict=True, extra="forbid", frozen=True, allow_inf_nan=False, populate_by_name=True
    )

    def replace(self, **values: Any) -> Self:
        """Return the part with other values of some keys, or with keys that it did not have.

        Raises pydantic's ValidationError for a key that is not described, or a value of another type.
        """
        return type(self)(**{name: getattr(self, name) for name in self.model_fields_set} | values)


def key(meaning: str, unit: str = "", alias: str | None = None) -> Any:
    """Describe a key that is always there; `unit` where its name does not tell it, or tells it too."""
    return Field(description=meaning, alias=alias, json_schema_extra=_of(unit))


def optional(meaning: str, unit: str = "", alias: str | None = None) -> Any:
    """Describe a key that is there only where it was asked for, or where it has a meaning."""
    return Field(default=None, description=meaning, alias=alias, json_schema_extra=_of(unit))


def present(found: Mapping[Name, Value | None]) -> dict[Name, Value]:
    """Return what there is of some tables that may be missing, by name."""
    return {name: value for name, value in found.items() if value is not None}


def known(value: Value | None) -> Value:
    """Return what is always there beside something else, as the configurations of a history that has a curve."""
    assert value is not None
    return value


def first_error(error: ValidationError) -> str:
    """Return the key of the first error, what is wrong there, and how many more there are."""
    errors = error.errors(include_url=False, include_input=False)
    place = ""
    for part in errors[0]["loc"]:
        place += f"[{part}]" if isinstance(part, int) else f"{'.' * bool(place)}{part}"
    wrong = {"missing": "missing", "extra_forbidden": "unknown key"}.get(errors[0]["type"], errors[0]["msg"])
    more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
    return f"{place or 'the whole'}: {wrong}{more}"


def _of(unit: str) -> dict[str, Any] | None:
    return {"unit": unit} if unit else None
