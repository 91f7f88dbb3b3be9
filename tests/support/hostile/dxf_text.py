"""Small DXF files as text, with any values in them."""

from collections.abc import Iterable, Sequence

from hypothesis import strategies as st

from tests.support.hostile.strategies import NAMES, NUMBERS

Points = Sequence[Sequence[object]]


def polyline(points: Points, layer: str = "WALL", closed: object = 1, extra: str = "") -> str:
    """A LWPOLYLINE of points (x, y) or (x, y, bulge)."""
    vertices = "".join(
        f" 10\n{x}\n 20\n{y}\n" + "".join(f" 42\n{bulge}\n" for bulge in rest) for x, y, *rest in points
    )
    head = f"  0\nLWPOLYLINE\n  8\n{layer}\n100\nAcDbEntity\n100\nAcDbPolyline\n"
    return f"{head} 90\n{len(points)}\n 70\n{closed}\n{extra}{vertices}"


def rectangle(x0: float, z0: float, x1: float, z1: float, layer: str = "WALL") -> str:
    """A rectangle as a LWPOLYLINE."""
    return polyline([(x0, z0), (x1, z0), (x1, z1), (x0, z1)], layer)


def insert(name: str, at: Sequence[object] = (0, 0), tags: Iterable[tuple[int, object]] = ()) -> str:
    """An INSERT of a block; further tags such as scales (41, 42) and arrays (70, 71, 44, 45)."""
    more = "".join(f"{code:3}\n{value}\n" for code, value in tags)
    head = f"  0\nINSERT\n  8\n0\n100\nAcDbEntity\n100\nAcDbBlockReference\n  2\n{name}\n"
    return f"{head} 10\n{at[0]}\n 20\n{at[1]}\n{more}"


def block(name: str, entities: str) -> str:
    """A block of entities."""
    head = f"  0\nBLOCK\n  8\n0\n100\nAcDbEntity\n100\nAcDbBlockBegin\n  2\n{name}\n 70\n0\n 10\n0\n 20\n0\n"
    return f"{head}{entities}  0\nENDBLK\n  8\n0\n100\nAcDbEntity\n100\nAcDbBlockEnd\n"


def drawing(entities: str, blocks: str = "", unit: object = 6) -> str:
    """A whole file."""
    header = (
        f"  0\nSECTION\n  2\nHEADER\n  9\n$ACADVER\n  1\nAC1015\n  9\n$INSUNITS\n 70\n{unit}\n  0\nENDSEC\n"
    )
    middle = f"  0\nSECTION\n  2\nBLOCKS\n{blocks}  0\nENDSEC\n" if blocks else ""
    return f"{header}{middle}  0\nSECTION\n  2\nENTITIES\n{entities}  0\nENDSEC\n  0\nEOF\n"


WALL = rectangle(-1, -1, 3, 0, "BASE") + "".join(
    rectangle(k, j, k + 1, j + 1) for j in range(2) for k in range(2)
)
WHOLE = drawing(
    WALL + polyline([(0, 2), (1, 2, 0.4), (1, 3), (0, 3)]) + insert("STONE", (1, 2), [(41, 1), (42, 1)]),
    block("STONE", rectangle(0, 0, 1, 1, "0")),
)


@st.composite
def hostile_drawings(draw: st.DrawFn) -> str:
    """A wall beside polylines and INSERTs with hostile coordinates, bulges, scales, arrays, layers and flags."""
    number = st.sampled_from(NUMBERS) | st.floats(-5, 5, allow_nan=False).map(repr)
    layer = st.sampled_from([name for name in NAMES if "\n" not in name and "\r" not in name]) | st.just(
        "WALL"
    )
    entities = [WALL] if draw(st.booleans()) else []
    for _ in range(draw(st.integers(0, 3))):
        points = draw(st.lists(st.tuples(number, number) | st.tuples(number, number, number), max_size=5))
        tags = draw(
            st.sampled_from(
                ("", " 38\n{}\n", "210\n{}\n220\n0\n230\n1\n", " 43\n{}\n", " 60\n1\n", " 62\n{}\n")
            )
        )
        entities.append(
            polyline(
                points, draw(layer), draw(st.sampled_from((0, 1, 129, -1, "x"))), tags.format(draw(number))
            )
        )
    for _ in range(draw(st.integers(0, 2))):
        codes = st.sampled_from((41, 42, 43, 50, 70, 71, 44, 45, 210, 220, 230))
        tags = draw(st.lists(st.tuples(codes, number), max_size=4))
        entities.append(
            insert(draw(st.sampled_from(("STONE", "LOOP", "ABSENT"))), (draw(number), draw(number)), tags)
        )
    blocks = block("STONE", rectangle(0, 0, 1, 1, "0")) + block(
        "LOOP", insert("STONE", (0, 1), [(41, draw(number))])
    )
    return drawing("".join(entities), blocks, draw(st.sampled_from((6, 4, 0, 99, -1, "x"))))
