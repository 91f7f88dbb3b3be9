"""A drawing as blocks: every closed outline of model space, with what its layer says of it, and all that is wrong."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, fields, replace
from difflib import get_close_matches
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from ezdxf import units
from ezdxf.document import Drawing as Document
from ezdxf.entities.dxfentity import DXFTagStorage
from ezdxf.math import Matrix44
from ezdxf.path import make_path
from scipy.spatial import cKDTree

from mechanics.errors import DrawingError, Fault, FaultyDrawingError, Outline, listed, require
from mechanics.messages import Message, headed, layer_key, message, visible
from mechanics.model.block import Block, Material, default_tolerance
from mechanics.model.dxf import Placed, covered, open_document, placed_entities
from mechanics.model.layout import NEAR
from mechanics.model.polylines import (
    FARTHEST,
    MOST_POINTS,
    PlacedOutline,
    fault_of,
    is_polyline,
    placed_outline,
    view_of,
)
from mechanics.types import Array

INSUNITS = {"mm": units.MM, "cm": units.CM, "m": units.M}
METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}
CRACK_LAYERS = {"fessure", "cracks"}  # by `layer_key`: what was surveyed, no blocks
LINES = {"LINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE", "LWPOLYLINE", "POLYLINE"}  # that draw cracks
CHORD = 1e-3  # m: of a curved crack from its chords
UNEVEN = 1e-6  # m: heights out of the drawing's plane of which there is a warning
# beside polylines; a POLYLINE is here a mesh, an INSERT an external reference
SHAPES = LINES | {"MLINE", "SOLID", "TRACE", "3DFACE", "REGION", "BODY", "HATCH", "MPOLYGON"}
SHAPES |= {"3DSOLID", "SURFACE", "MESH", "INSERT"}


@dataclass(frozen=True, slots=True)
class Layer:
    """What the blocks of one drawing layer are; the fields are those of Block. `ignore`: nothing on it is read."""

    material: Material
    depth: float
    support: str | None = None
    vertical_load: float = 0.0
    load_has_mass: bool = True
    segments: int | None = None
    ignore: bool = False


@dataclass(frozen=True)
class Drawing(Sequence[Block]):
    """Blocks of a drawing, warnings about it, and the largest distance (m) of an arc from its chords.

    It is the sequence of its blocks: Assembly(read_drawing(…)). `faults`: what keeps outlines from being blocks, and
    layers that are not there; `outlines`: all of them, to draw; `cracks`: lines (n, 2) m of the CRACK_LAYERS.
    """

    blocks: tuple[Block, ...]
    warnings: tuple[Message, ...]
    sagitta: float = 0.0
    faults: tuple[Fault, ...] = ()
    outlines: tuple[Outline, ...] = ()
    cracks: tuple[Array, ...] = ()

    def __len__(self) -> int:
        """Return the number of blocks."""
        return len(self.blocks)

    def __getitem__(self, index: Any) -> Any:
        """Return a block by its number, or some."""
        return self.blocks[index]


def of_block(layer: Layer) -> dict[str, Any]:
    """Return what a layer says of its blocks, by the fields of Block."""
    return {field.name: getattr(layer, field.name) for field in fields(layer) if field.name != "ignore"}


def read_drawing(
    path: str | Path, unit: str, default: Layer, layers: Mapping[str, Layer] = {},
    sagitta: float | None = None,
) -> Drawing:  # fmt: skip
    """Read the blocks of a DXF drawing (text or binary, R12 and later); their vertices are in m.

    Each closed LWPOLYLINE, 2D or plane 3D POLYLINE of model space is a block, also inside INSERTs (nested, scaled,
    mirrored, arrays). `unit` ("mm", "cm", "m") is the drawing's. `layers` replaces `default` by layer name, in any case
    of letters. A front view, drawn in a vertical plane, is turned: z is up. Layers FESSURE and CRACKS hold surveyed
    cracks. Arcs become chords no farther than `sagitta` (m) from them, by default a thousandth of the arc's width; one
    edge of two blocks gives both the same vertices. What is hidden, clipped away or no polyline is left out with a
    warning; so is an open polyline on a layer that is not named and has no closed one.

    Raises DrawingError listing all that is wrong, with file, layer, handle and coordinates in drawing units; ValueError
    for an unknown `unit` or a `sagitta` that is not positive.
    """
    drawing = survey_drawing(path, unit, default, layers, sagitta)
    if drawing.faults:
        raise FaultyDrawingError(str(path), drawing.faults, drawing.outlines)
    return drawing


def survey_drawing(
    path: str | Path, unit: str, default: Layer, layers: Mapping[str, Layer] = {},
    sagitta: float | None = None, tolerance: float | None = None,
) -> Drawing:  # fmt: skip
    """Return what `read_drawing` does, with its faults, small beside a `tolerance` (m), not raising them."""
    return Sheet.of(path, unit, default, layers, sagitta, tolerance).drawing


@dataclass(frozen=True, eq=False)
class Sheet:
    """A document as it is now, and how it becomes blocks; what is found in it is found once.

    `damage`: what was mended to read it; `scale`: m per drawing unit; `layers` by the name that the project has.
    """

    document: Document
    damage: Sequence[Message]
    path: Path
    unit: str
    default: Layer
    layers: Mapping[str, Layer]
    sagitta: float | None
    tolerance: float | None

    @classmethod
    def of(
        cls, path: str | Path, unit: str, default: Layer, layers: Mapping[str, Layer], sagitta: float | None,
        tolerance: float | None,
    ) -> Sheet:  # fmt: skip
        """Open a drawing. Raises DrawingError where it cannot be read, ArgumentError for unit or sagitta."""
        require(unit in METRES, "unit", unit, '"mm", "cm" or "m"')
        require(sagitta is None or 0.0 < sagitta < np.inf, "sagitta", sagitta, "positive, in m, or None")
        document, damage = open_document(Path(path))
        return cls(document, damage, Path(path), unit, default, layers, sagitta, tolerance)

    @property
    def own_unit(self) -> str | None:
        """The unit that the file itself states, None: none that is known."""
        return {code: unit for unit, code in INSUNITS.items()}.get(self.document.units)

    @property
    def scale(self) -> float:
        """Metres per drawing unit."""
        return METRES[self.unit]

    @cached_property
    def named(self) -> dict[str, tuple[str, Layer]]:
        """The layers that the project names, by key: name and what it says."""
        return {layer_key(name): (name, layer) for name, layer in self.layers.items()}

    @cached_property
    def _entities(self) -> list[Placed]:
        return placed_entities(self.document, self.path)

    @cached_property
    def placed(self) -> list[Placed]:
        """The entities of model space, those of INSERTs where these put them, without those of ignored layers."""
        others = {key for key, (_, layer) in self.named.items() if layer.ignore} | self._surveyed
        return [p for p in self._entities if layer_key(p.layer) not in others]

    @property
    def _surveyed(self) -> Set[str]:
        """The layers of surveyed cracks: those of that name, unless the project says what else they are."""
        return CRACK_LAYERS - self.named.keys()

    @cached_property
    def cracks(self) -> tuple[Array, ...]:
        """The surveyed cracks as lines (n, 2), m, curves by chords: what is drawn on their layers, texts aside."""
        found = []
        for p in self._entities:
            if p.hidden or layer_key(p.layer) not in self._surveyed or p.entity.dxftype() not in LINES:
                continue
            path = make_path(p.entity).transform(p.to_model * self._view)
            points = self.scale * np.array([v.xyz[:2] for v in path.flattening(CHORD / self.scale)])
            if len(points) > 1 and bool((abs(points) <= FARTHEST).all()):
                found.append(points)
        return tuple(found)

    @cached_property
    def _view(self) -> Matrix44:
        """Turns a front view, drawn in a vertical plane, into the plane of the drawing."""
        view = view_of(self._placed[0])
        axes = np.eye(3) if view is None else view
        return Matrix44(np.block([[axes, np.zeros((3, 1))], [np.zeros((1, 3)), np.ones((1, 1))]]).ravel())

    @cached_property
    def _placed(self) -> tuple[list[PlacedOutline], list[Placed]]:
        """The outlines that are shown, as they lie in model space, and the polylines that clips hide."""
        outlines, clipped = [], []
        count = 0
        for source in self.placed:
            if source.hidden or not is_polyline(source.entity):
                continue
            outline = placed_outline(source, self.scale, self.sagitta)
            seen, insert = ("whole", "") if outline.broken else source.cut(outline.line)
            if seen == "nothing":
                clipped.append(source)
                continue
            if seen == "part":
                why = f"is cut by the clip of INSERT {insert}; draw what is left of it, or take the clip off"
                outline = replace(outline, broken=why)
            outlines.append(outline)
            count += len(outline.points)
            if count > MOST_POINTS:
                text = f"more than {MOST_POINTS} vertices, those of arcs included; simplify the outlines, or write a "
                raise DrawingError(f"{self.path}: {text}larger geometry.sagitta_m")
        return outlines, clipped

    @cached_property
    def _shown(self) -> tuple[list[PlacedOutline], list[Placed], list[Message]]:
        """The outlines that are shown, in the plane of the drawing, the polylines that clips hide, and warnings."""
        outlines, clipped = list(self._placed[0]), self._placed[1]
        warnings = []
        view = view_of(outlines)
        if view is not None:
            for k, old in enumerate(outlines):
                source = replace(old.source, to_model=old.source.to_model * self._view)
                turned = placed_outline(source, self.scale, self.sagitta)
                outlines[k] = replace(turned, broken=old.broken or turned.broken)
            x, y = (round(float(along), 6) + 0.0 for along in view[:2, 0])
            told = message(
                "drawn in a vertical plane and turned: x of blocks and points is along ({x:.4g}, {y:.4g}, 0) of "
                "the drawing, z is its z", x=x, y=y,
            )  # fmt: skip
            warnings.append(told)
        drawn = [(o.source, o.line) for o in outlines]
        space = self.document.modelspace()
        for number, wipeout in covered(drawn, self.placed, space, np.eye(3) if view is None else view):
            why = f"is covered by WIPEOUT {wipeout}; delete the one or the other"
            outlines[number] = replace(outlines[number], broken=why)
        return outlines, clipped, warnings

    @cached_property
    def closed(self) -> list[PlacedOutline]:
        """The closed outlines that are shown."""
        return [o for o in self._shown[0] if o.closed]

    @cached_property
    def outlines(self) -> list[PlacedOutline]:
        """The outlines that are or should be blocks: of open ones, where layers are named, those beside blocks."""
        holding = {layer_key(o.source.layer) for o in self.closed} | self.named.keys()
        every = not self.layers or not self.closed
        return [o for o in self._shown[0] if every or layer_key(o.source.layer) in holding]

    @cached_property
    def wrong(self) -> dict[str, Fault]:
        """What keeps outlines from being blocks, by their handles."""
        found = ((o, fault_of(o, self.scale, self.reach)) for o in self.outlines)
        return {o.source.handle: fault for o, fault in found if fault is not None}

    @cached_property
    def sources(self) -> list[PlacedOutline]:
        """The outline of each block."""
        return [o for o in self.closed if o.source.handle not in self.wrong]

    @cached_property
    def reach(self) -> float:
        """How far, m, a repair moves what is drawn, NEAR tolerances of the joints; 0: nothing tells them."""
        if self.tolerance is not None:
            return NEAR * self.tolerance
        rings = [o.points[:, :2] for o in self.closed if not o.broken and len(o.points)]
        return NEAR * self.scale * default_tolerance(rings) if rings else 0.0

    def layer(self, outline: PlacedOutline) -> Layer:
        """Return what the project says of the layer of an outline."""
        return self.named.get(layer_key(outline.source.layer), ("", self.default))[1]

    def block(self, outline: PlacedOutline) -> Block:
        """Return the block of an outline."""
        layer, source = self.layer(outline), outline.source
        points = self.scale * outline.points[:, :2]
        return Block(points, **of_block(layer), layer=source.layer, handle=source.handle)

    @cached_property
    def drawing(self) -> Drawing:
        """The blocks, and all that is wrong or odd."""
        faults = [*self.wrong.values(), *self._by_lines(), *self._frozen_on_sheets()]
        if faults or any(is_polyline(p.entity) for p in self.placed):
            faults = [*self._layer_faults(), *faults]
        if not self.closed and not faults:
            faults = [Fault("layer", self._nothing())]
        blocks = tuple(map(self.block, self.sources))
        warnings = tuple(headed(self.path.name, warning) for warning in self._warnings())
        sagitta = self.scale * max((o.sagitta for o in self.sources), default=0.0)
        outlines = tuple(
            Outline(self.scale * o.points[:, :2], o.source.layer, o.closed, self.layer(o).support is not None)
            for o in self.outlines
            if o.is_near(self.scale) and len(o.points) > 1
        )
        return Drawing(blocks, warnings, sagitta, tuple(faults), outlines, self.cracks)

    def _layer_faults(self) -> Iterator[Fault]:
        """Name the layers of the project that the drawing does not have or does not show."""
        names = [visible(each.dxf.name) for each in self.document.layers] + [p.layer for p in self._entities]
        drawn = {layer_key(name): name for name in names}
        hidden = Counter(layer_key(p.layer) for p in self._hidden())
        for key, (name, _) in self.named.items():
            if key not in drawn:
                nearest = [drawn[each] for each in get_close_matches(key, drawn, n=1)]
                has = ", ".join(listed(sorted(drawn.values())))
                hint = f'did you mean "{nearest[0]}"?' if nearest else f"it has {has}"
                yield Fault("layer", f"layers.{name} of the project is not in the drawing; {hint}")
            elif n := hidden[key]:
                remedy = "show them, or take the layer out of the project"
                text = f'layer "{name}" has {n} polylines that are frozen, off or invisible; {remedy}'
                yield Fault("layer", text)

    def _hidden(self) -> Iterator[Placed]:
        return (p for p in self.placed if p.hidden and is_polyline(p.entity))

    def _frozen_on_sheets(self) -> Iterator[Fault]:
        """Name the layers with outlines that every viewport hides, and that the project does not name."""
        views: list[Any] = [
            v for sheet in self.document.layouts for v in sheet.query("VIEWPORT") if v.dxf.id != 1
        ]
        frozen = [{layer_key(name) for name in view.frozen_layers} for view in views]
        hidden = set.intersection(*frozen) if frozen else set()
        for name in sorted({o.source.layer for o in self.closed}):
            if layer_key(name) in hidden - self.named.keys():
                remedy = f'freeze it there too, or write [layers."{name}"] in the project'
                text = f'layer "{name}" is frozen in every viewport and shown in model space; {remedy}'
                yield Fault("layer", text)

    @cached_property
    def enclosed(self) -> list[tuple[str, Array]]:
        """What LINEs enclose beside blocks, stones as a rule: layer and ring (n, 2), drawing units, of each."""
        near = [o.points[:, :2] for o in self.outlines if len(o.points) > 2 and o.is_near(self.scale)]
        holding = {layer_key(o.source.layer) for o in self.closed}
        drawn: dict[str, list[Array]] = {}
        for p in self.placed:
            if p.entity.dxftype() == "LINE" and not p.hidden and layer_key(p.layer) in holding:
                path = make_path(p.entity).transform(p.to_model * self._view)
                ends = np.array([path.start.vec2, path.end.vec2])
                if (abs(ends) <= FARTHEST / self.scale).all():
                    drawn.setdefault(p.layer, []).append(ends)
        if not (near and drawn and self.reach):
            return []
        drawn_rings = np.array([shapely.Polygon(points) for points in near])
        crossed = ~shapely.is_valid(drawn_rings)  # not worth the work of all their crossings
        drawn_rings[crossed] = shapely.convex_hull(drawn_rings[crossed])
        outer, _ = shapely.STRtree(drawn_rings).query(drawn_rings, predicate="contains_properly")
        within = np.bincount(outer, minlength=len(near))
        rings = [each for each, n in zip(drawn_rings, within, strict=True) if 2 * n <= len(near)]  # no frames
        stones, reach = shapely.STRtree(rings), self.reach / self.scale
        found = []
        for layer, lines in drawn.items():
            ends = np.concatenate(lines)
            first = [min(k) for k in cKDTree(ends).query_ball_point(ends, reach)]  # ends that meet are one
            edges = {
                tuple(sorted(edge)) for edge in np.reshape(first, (-1, 2)).tolist() if edge[0] != edge[1]
            }
            faces = shapely.polygonize([shapely.LineString(ends[list(edge)]) for edge in sorted(edges)])
            for face in faces.geoms:
                beside = [rings[k] for k in stones.query(face, predicate="dwithin", distance=reach)]
                if beside and shapely.union_all(beside).intersection(face).area < 0.5 * face.area:
                    found.append((layer, np.array(face.exterior.coords)))
        return found

    def _by_lines(self) -> Iterator[Fault]:
        for layer, line in self.enclosed:
            x, z = (np.round(0.5 * (line.min(axis=0) + line.max(axis=0)), 9) + 0.0).tolist()
            text = (
                f'layer "{layer}": LINEs around ({x:.9g}, {z:.9g}) enclose what is no block; join them to a closed '
                "polyline, or move them to a layer of their own if it is none"
            )
            yield Fault("lines", text, np.array([[x, z]]), (line,)).scaled(self.scale)

    def _nothing(self) -> str:
        """Describe what a drawing without polylines in model space has instead."""
        paper = [
            f'layer "{visible(e.dxf.layer)}", {e.dxftype()} {e.dxf.handle} of layout "{layout.name}"'
            for layout in self.document.layouts
            for e in layout
            if not layout.is_modelspace and is_polyline(e)
        ]
        if paper:
            return f"the polylines are in paper space ({paper[0]}, {len(paper)} in all); move them to model space"
        counts = Counter(("hidden " if p.hidden else "") + p.entity.dxftype() for p in self.placed)
        kinds = [f"{n} {visible(kind)}" for kind, n in counts.most_common()]
        found = ", ".join(listed(kinds)) or "nothing at all"
        return f"nothing closed is in model space, but {found}; draw each block as one closed polyline"

    def _warnings(self) -> Iterator[Message]:
        """Yield what is odd: the file, the unit, layers without blocks, and what looks like a block and is none."""
        yield from self.damage
        outlines, clipped, turned = self._shown
        yield from turned
        own = units.unit_name(self.document.units)
        if own.lower() != "unitless" and self.own_unit != self.unit:
            yield message(
                "$INSUNITS says {own}, the project {unit}, which is used; check the sizes",
                own=own, unit=self.unit,
            )  # fmt: skip
        heights = [np.ptp(o.points[:, 2]) for o in self.sources]
        if uneven := [h for h in heights if h > 0.0 and h * self.scale > UNEVEN]:
            yield message(
                "heights out of the plane are left out, of up to {height:.3g} m; outlines: {count}",
                height=self.scale * max(uneven), count=len(uneven),
            )  # fmt: skip
        holding = {layer_key(o.source.layer) for o in self.closed}
        for key, (name, layer) in self.named.items():
            if key not in holding and not layer.ignore:
                yield message(
                    'layer "{name}" holds no block: what the project says of it has no effect', name=name
                )
        for name, count in Counter(p.layer for p in self._hidden()).items():
            yield message(
                'layer "{name}": frozen, off or invisible polylines left out: {count}', name=name, count=count
            )
        for name, count in Counter(p.layer for p in clipped).items():
            yield message(
                'layer "{name}": polylines left out that clips of INSERTs hide: {count}',
                name=name,
                count=count,
            )
        if open_ := [o for o in outlines if not o.closed]:
            yield message(
                "open polylines on layers without blocks left out: {count}, first: {where}",
                count=len(open_), where=open_[0].source.at(*open_[0].points[[0, -1]]),
            )  # fmt: skip
        rest = [p for p in self.placed if not (p.hidden or is_polyline(p.entity))]
        shapes = [p for p in rest if p.entity.dxftype() in SHAPES or isinstance(p.entity, DXFTagStorage)]
        if shapes:
            kinds = Counter(p.entity.dxftype() for p in shapes)
            yield message(
                "left out, being no closed polylines: {found}, on layers {layers}",
                found=listed([f"{n} {visible(kind)}" for kind, n in kinds.most_common()]),
                layers=listed(sorted({p.layer for p in shapes})),
            )
