"""Results of finished analyses in the output folder, found again by the fingerprint of their inputs.

An entry is a file of two lines: the digest of the second, and the result as JSON. It is written whole or not at all;
one that is damaged counts as absent. Nothing in it is executed, as what libraries for such stores (diskcache, joblib)
pickle would be.
"""

from __future__ import annotations

import hashlib
import json
import os
from contextlib import suppress
from dataclasses import dataclass, fields, is_dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from assessment.runtime.files.atomic_files import write_atomically

FOLDER = ".stages"  # in the output folder
MOST_BYTES = 300_000_000  # of all entries; the least recently used are removed first
KIND, ARRAY = "·kind", "·array"
# packages whose dataclasses, and parts of results.json, results are made of
OWN = ("assessment.", "mechanics.")


def packed(result: Any) -> str:
    """Return a result of an analysis as JSON on one line; floats keep every bit, tuples become lists."""
    return json.dumps(_marked(result), default=_plain, ensure_ascii=False)


def unpacked(text: str) -> Any:
    """Return what `packed` was given."""
    return json.loads(text, object_hook=_restored)


@dataclass(frozen=True)
class Store:
    """Entries in a folder, one file per fingerprint."""

    folder: Path

    def find(self, key: str) -> str | None:
        """Return the packed result that was kept under a fingerprint; None where there is none, or it is damaged."""
        text = self.read(key)
        if text is not None:
            with suppress(OSError):
                os.utime(self.folder / key)
        return text

    def read(self, key: str) -> str | None:
        """Return the same without recording that it was used: nothing is written."""
        path = self.folder / key
        try:
            if path.stat().st_size > MOST_BYTES:
                return None
            digest, _, text = path.read_text(encoding="utf-8").partition("\n")
        except (OSError, UnicodeDecodeError):
            return None
        return text if digest == _digest(key, text) else None

    def keep(self, key: str, text: str) -> None:
        """Keep a packed result; if it cannot be written, the run goes on without it."""
        with suppress(OSError):
            write_atomically(self.folder / key, f"{_digest(key, text)}\n{text}".encode())

    def prune(self, most: int = MOST_BYTES) -> None:
        """Remove temporary files of killed runs and, beyond `most` bytes in all, the least recently used entries."""
        with suppress(OSError):
            used = [(path.stat(), path) for path in self.folder.iterdir()]
            room = most
            for status, path in sorted(used, key=lambda item: -item[0].st_mtime_ns):
                room -= status.st_size
                if room < 0 or path.name.startswith("."):
                    path.unlink()


def _digest(key: str, text: str) -> str:
    return hashlib.sha256(f"{key}\n{text}".encode()).hexdigest()


def _plain(value: Any) -> Any:
    """Return what JSON has no form for as an object that `_restored` knows."""
    import numpy as np

    if isinstance(value, np.ndarray):
        return {ARRAY: value.tolist(), "shape": value.shape, "type": value.dtype.str}
    if isinstance(value, np.generic):
        return value.item()
    kind = type(value)
    if kind.__module__.startswith(OWN):
        tag = {KIND: f"{kind.__module__}:{kind.__name__}"}
        if is_dataclass(value):
            return tag | {field.name: _marked(getattr(value, field.name)) for field in fields(value)}
        if _is_part(kind):
            return tag | _marked(value.model_dump(by_alias=True, exclude_unset=True))
    raise TypeError(f"{type(value).__name__}: not a result of an analysis")


def _marked(value: Any) -> Any:
    """Return a value with its messages as objects that `_restored` knows: JSON takes them for plain strings.

    Lists of numbers are left as they are, by their first item.
    """
    from mechanics.messages import Message

    if isinstance(value, Message):
        kind = f"{Message.__module__}:{Message.__name__}"
        return {KIND: kind, "template": value.template, "fields": _marked(value.fields)}
    if isinstance(value, dict):
        return {name: _marked(item) for name, item in value.items()}
    if isinstance(value, list | tuple) and value and not isinstance(value[0], int | float):
        return [_marked(item) for item in value]
    return value


def _is_part(kind: type) -> bool:
    from assessment.results.schema.part import Part  # late: as above

    return issubclass(kind, Part)


def _is_message(kind: type) -> bool:
    from mechanics.messages import Message  # late: as above

    return kind is Message


def _restored(content: dict[str, Any]) -> Any:
    if ARRAY in content:
        import numpy as np

        return np.array(content[ARRAY], dtype=content["type"]).reshape(content["shape"])
    if KIND in content:
        module, _, name = content.pop(KIND).partition(":")
        # late: a run that takes over all results needs none
        kind = getattr(import_module(module), name) if module.startswith(OWN) else None
        if not isinstance(kind, type) or not (is_dataclass(kind) or _is_part(kind) or _is_message(kind)):
            raise ValueError(f"{module}:{name}: not a result of an analysis")
        return kind(**content)
    return content
