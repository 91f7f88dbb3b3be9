"""Changes of a project file: keys set and deleted in the TOML text, and the versions that undo goes back to."""

from __future__ import annotations

import copy
import hashlib
import json
import tomllib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from assessment.project.problems import project_error, schema_problems
from assessment.project.project import SOURCES, TOML, Project, spelt
from assessment.project.schema import KeyPath, ProjectContent, alternatives, annotation_at
from assessment.project.toml import read_toml
from assessment.runtime.errors import ProjectError
from assessment.runtime.files import write_atomically

OWN = ".assesto"  # folder beside project.toml: versions of it, where the page is, what was dropped
VERSIONS = 200  # that are kept
Change = tuple[KeyPath, Any]
"""Where a value stands and what it becomes; None: it is deleted, an entry of a list with its place."""


class ConflictError(Exception):
    """The file is not the one that the change was made in, or the project not the one that was asked of."""


def digest_of(content: bytes) -> str:
    """Return by which a page knows a version of the project file."""
    return hashlib.sha256(content).hexdigest()[:16]


def model_tag(project: Project) -> str:
    """Return by which a page knows a drawing with all that a run reads beside it, of files as far as all are there."""
    with suppress(OSError, ValueError):
        return tags_of(spelt(project.echoed()), project.digests())["numbers"]
    return tags_of(spelt(project.echoed()), {})["numbers"]


def tags_of(content: Mapping[str, Any], inputs: Mapping[str, str]) -> dict[str, str]:
    """Return digests of what numbers follow from, and of what is printed with them; `inputs`: digests of the files."""
    page = {key: content[key] for key in ("title", "report")}
    numbers = [
        {**content, **dict.fromkeys(page)},
        [item for item in inputs.items() if item[0] not in SOURCES],
    ]
    read = {"numbers": numbers, "page": page}
    return {key: digest_of(json.dumps(each, sort_keys=True).encode()) for key, each in read.items()}


def edited(text: str, changes: Sequence[Change]) -> str:
    """Return the TOML text with all changes made: comments, order and what is not changed stay as they are written.

    Raises ProjectError, one line per problem, where the content would have wrong keys, types or ranges, or a change is
    at no place of a project file.
    """
    import tomlkit

    document: Any = tomlkit.parse(text)
    content = tomllib.loads(text)
    for path, value in changes:
        try:
            # a page, whose JSON has no infinity, writes it as a text
            unbounded = value in ("inf", "-inf") and float in alternatives(annotation_at(path))
            given = float(value) if unbounded else value
            for node in (content, document):
                with suppress(ValueError):  # null within has no form in TOML, and is refused below
                    _delete(node, path) if given is None else _set(node, path, copy.deepcopy(given))
        except (LookupError, TypeError, AttributeError):
            raise ProjectError(f"{TOML}: {'.'.join(map(str, path))}: there is no such place") from None
    try:
        ProjectContent.model_validate(content)
    except ValidationError as error:
        raise project_error(TOML, schema_problems(error, content), {}) from None
    changed = tomlkit.dumps(document)
    said, asked = (
        json.dumps(each, sort_keys=True, default=str) for each in (tomllib.loads(changed), content)
    )
    if said != asked:
        raise RuntimeError(f"{TOML}: the text does not say what was asked for")
    return changed


def _set(node: Any, path: KeyPath, value: Any) -> None:
    """Set what stands at a path, with the tables and lists on the way that are not there."""
    keys: list[Any] = [*path]
    while len(keys) > 1 and (keys[0] < len(node) if isinstance(keys[0], int) else keys[0] in node):
        node = node[keys.pop(0)]
    for part in reversed(keys[1:]):
        value = [value] if part == 0 else {part: value}
    key = keys[0]
    if isinstance(key, int) and key == len(node):
        node.append(value)
    # what agrees stays as it is written; True is not 1
    elif isinstance(key, int) or key not in node or node[key] != value or isinstance(value, bool):
        node[key] = value


def _delete(node: Any, path: KeyPath) -> None:
    """Delete what stands at a path, and the key of a list with its last entry."""
    with suppress(KeyError, IndexError):
        parent = node
        for part in path[:-1]:
            parent = parent[part]
        del parent[path[-1]]
        if isinstance(parent, list) and not parent:
            _delete(node, path[:-1])


class Versions:
    """The versions of a project file, `NNNN.toml` in a folder of their own, and which of them is the present one."""

    def __init__(self, folder: Path) -> None:
        self.file, self.folder = folder / TOML, folder / OWN / "history"

    def write(self, changes: Sequence[Change], digest: str) -> str:
        """Make changes in the file whose digest the page knew; return its new digest.

        Raises ConflictError where the file is another one by now, ProjectError as `edited` and for a file that is no
        TOML, OSError where a file cannot be written: nothing is changed then.
        """
        before = self._known(digest)
        read_toml(self.file)  # what is refused here is nothing to parse
        after = edited(before.decode("utf-8-sig"), changes).encode()
        if after != before:
            self._go_to(self._added(self.taken_in(before), after))
        return digest_of(after)

    def step(self, by: int, digest: str | None) -> str:
        """Go back (-1) or forward (1) by a version, to the byte; return the digest of the file.

        What was changed elsewhere is taken in as a version first; a file that was taken away comes back as it was.
        Raises ConflictError as `write`, ProjectError where there is no such version.
        """
        to = self.taken_in(self._known(digest)) + by if self.file.exists() else self._at()
        if to not in self._versions():
            raise ProjectError(f"{TOML}: nothing to {'undo' if by < 0 else 'redo'}")
        return digest_of(self._go_to(to))

    def steps(self) -> tuple[bool, bool]:
        """Return whether there is a version to go back to, and one to go forward to."""
        versions, at = self._versions(), self._at()
        known = at in versions
        same = known and self.file.is_file() and self._path(at).read_bytes() == self.file.read_bytes()
        return known and (not same or at - 1 in versions), same and at + 1 in versions

    def _known(self, digest: str | None) -> bytes:
        content = self.file.read_bytes()
        if digest_of(content) != digest:
            raise ConflictError(f"{TOML} was changed elsewhere")
        return content

    def taken_in(self, present: bytes) -> int:
        """Return the number of the present version, which is made one where it is not the one at which undo is."""
        at = self._at()
        if at in self._versions() and self._path(at).read_bytes() == present:
            return at
        write_atomically(self.folder / "at", str(number := self._added(at, present)).encode())
        return number

    def _added(self, at: int, content: bytes) -> int:
        """Keep a version after another one, in the place of those that came after it; return its number."""
        write_atomically(self._path(at + 1), content)  # first: on a full disk no other version goes
        for version in self._versions():
            if version > at + 1 or version <= at + 1 - VERSIONS:
                self._path(version).unlink()
        return at + 1

    def _go_to(self, number: int) -> bytes:
        content = self._path(number).read_bytes()
        write_atomically(self.file, content)
        write_atomically(self.folder / "at", str(number).encode())
        return content

    def _at(self) -> int:
        """Return the number of the version that undo is at, 0 where there is none."""
        with suppress(OSError, ValueError):
            return int((self.folder / "at").read_bytes())
        return 0

    def _versions(self) -> list[int]:
        return sorted(int(path.stem) for path in self.folder.glob("*.toml") if path.stem.isdecimal())

    def _path(self, number: int) -> Path:
        return self.folder / f"{number:04}.toml"
