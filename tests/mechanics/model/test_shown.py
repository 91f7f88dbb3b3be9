"""What a drawing hides is no block, or is refused by name: clips, states of dynamic blocks, wipeouts, viewports."""

import numpy as np
import pytest
from ezdxf.entities.dxfentity import DXFTagStorage
from ezdxf.lldxf.extendedtags import ExtendedTags
from ezdxf.math import Matrix44
from ezdxf.xclip import XClip
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.dxf import STONE, drawing, outline, read, refused

ROW = [(0, 0), (15, 0), (30, 0), (45, 0)]  # mm: lower left corners of squares of 10 mm


def square(x: float, y: float = 0.0, side: float = 10.0):
    return [(x, y), (x + side, y), (x + side, y + side), (x, y + side)]


def row(document, name: str = "ROW", base=(0, 0)):
    """A block with a row of four squares."""
    block = document.blocks.new(name, base_point=base)
    return block, [outline(block, square(*corner), "0") for corner in ROW]


def handles(result) -> list[str]:
    return [block.handle.rpartition("/")[2] for block in result.blocks]


def clip(insert, corners, inverted=False):
    XClip(insert).set_block_clipping_path(corners)
    if inverted:
        XClip(insert).invert_clipping_path(ignore_acad_compatibility=True)


@pytest.mark.parametrize(
    ("corners", "inverted", "shown"),
    [
        ([(-1, -1), (27, 11)], False, [0, 1]),
        ([(0, 0), (25, 10)], False, [0, 1]),  # along their edges
        ([(-1, -1), (27, -1), (27, 11), (-1, 11)], True, [2, 3]),
        ([(16, 1), (24, 9)], False, []),  # within a square there is none of its lines
        ([(16, 1), (24, 9)], True, [0, 1, 2, 3]),
    ],
)
def test_what_a_clip_leaves_is_read(corners, inverted, shown, tmp_path):
    document, space = drawing()
    _, squares = row(document)
    insert = space.add_blockref("ROW", (100, 50), dxfattribs={"layer": "WALL", "rotation": 30, "xscale": -2})
    clip(insert, corners, inverted)
    plain = outline(space, square(0))
    result = read(document, tmp_path)
    assert handles(result) == [*(squares[k].dxf.handle for k in shown), plain.dxf.handle]
    left = f'layer "WALL": polylines left out that clips of INSERTs hide: {4 - len(shown)}'
    assert [left in warning for warning in result.warnings] == [True] * (len(shown) < 4)


@settings(max_examples=15)
@given(
    at=st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)),
    turn=st.floats(-180.0, 180.0),
    scale=st.sampled_from([(1, 1), (2, 0.5), (-1, 1), (3, -2)]),
    base=st.tuples(st.floats(-20.0, 20.0), st.floats(-20.0, 20.0)),
    moved=st.booleans(),
)
def test_a_clip_drawn_in_model_space_goes_with_its_insert(at, turn, scale, base, moved, tmp_path_factory):
    """As CAD programs store it: the boundary where it was drawn, and the inverse of the INSERT as it was then."""
    document, space = drawing()
    _, squares = row(document, base=base)
    insert = space.add_blockref(
        "ROW", at, dxfattribs={"rotation": turn, "xscale": scale[0], "yscale": scale[1], "layer": "WALL"}
    )
    then = insert.matrix44()
    boundary = [(12, -1), (42, -1), (42, 11), (12, 11)]
    clip(insert, boundary)
    kept = XClip(insert).get_spatial_filter()
    kept.set_boundary_vertices(then.transform_vertices([(x, y, 0.0) for x, y in boundary]))
    kept.set_inverse_insert_matrix(Matrix44(np.linalg.inv(np.array(list(then)).reshape(4, 4)).ravel()))
    if moved:
        insert.dxf.insert, insert.dxf.rotation = (7.0, -3.0), 77.0
    result = read(document, tmp_path_factory.mktemp("clip"))
    assert handles(result) == [squares[1].dxf.handle, squares[2].dxf.handle]


def test_clips_that_cannot_be_followed_are_refused(tmp_path):
    document, space = drawing()
    _, squares = row(document)
    insert = space.add_blockref("ROW", (0, 0), dxfattribs={"layer": "WALL"})
    clip(insert, [(-1, -1), (20, 11)])
    cut = f"{insert.dxf.handle}/{squares[1].dxf.handle}"
    assert (
        f'layer "WALL", LWPOLYLINE {cut} at (15, 0) is cut by the clip of INSERT {insert.dxf.handle}; draw what'
        in refused(document, tmp_path)
    )
    insert.grid(size=(2, 1), spacing=(20, 50))
    assert "is an array with a clip; explode it and trim it" in refused(document, tmp_path)
    insert.grid(size=(1, 1), spacing=(0, 0))
    clip(insert, [(0, 0), (10, 10), (10, 0), (0, 10)])
    assert "has a clip whose boundary is no polygon" in refused(document, tmp_path)
    clip(insert, [(-1, -1), (21, 11)])
    XClip(insert).get_spatial_filter().dxf.has_front_clipping_plane = 1
    assert "is clipped in depth" in refused(document, tmp_path)


def with_states(document, *states) -> None:
    """Give a document the visibility states of a dynamic block, as DXF has them."""
    governed = sorted({entity.dxf.handle for state in states for entity in state})
    tags = [
        (0, "BLOCKVISIBILITYPARAMETER"),
        (5, document.entitydb.next_handle()),
        (330, document.rootdict.dxf.handle),
    ]
    tags += [(100, "AcDbBlockVisibilityParameter"), (281, 1), (301, "Visibility"), (302, "")]
    tags += [(93, len(governed)), *((331, handle) for handle in governed), (92, len(states))]
    for number, state in enumerate(states):
        tags += [(303, f"state {number}"), (94, len(state)), *((332, e.dxf.handle) for e in state), (95, 0)]
    text = "".join(f"{code}\n{value}\n" for code, value in tags)
    parameter = DXFTagStorage.load(ExtendedTags.from_text(text), document)
    document.entitydb.add(parameter)
    document.objects.add_object(parameter)


def test_states_of_a_dynamic_block_are_those_of_its_flags_or_refused(tmp_path):
    document, space = drawing()
    _, squares = row(document)
    insert = space.add_blockref("ROW", (0, 0))
    with_states(document, squares[:2], squares[2:])
    said = refused(document, tmp_path)
    assert f'INSERT {insert.dxf.handle}: which parts of the dynamic block "ROW" its visibility state' in said
    for each in squares[:2]:
        each.dxf.invisible = 1
    result = read(document, tmp_path)
    assert handles(result) == [each.dxf.handle for each in squares[2:]]
    assert [w for w in result.warnings if "frozen, off or invisible polylines left out: 2" in w]


def test_what_a_wipeout_covers_is_refused_and_what_lies_over_it_is_read(tmp_path):
    document, space = drawing()
    below = outline(space, square(0))
    wipeout = space.add_wipeout([(-1, -1), (25, -1), (25, 25), (-1, 25)], dxfattribs={"layer": "NOTES"})
    outline(space, square(10))
    outline(space, square(20))
    said = refused(document, tmp_path)
    handle = wipeout.dxf.handle
    assert said.endswith(
        f"LWPOLYLINE {below.dxf.handle} at (0, 0) is covered by WIPEOUT {handle}; delete the one or the other"
    )
    space.set_redraw_order({handle: "1"})
    assert len(read(document, tmp_path).blocks) == 3


def test_layers_that_every_viewport_hides_are_refused_unless_the_project_names_them(tmp_path):
    document, space = drawing()
    outline(space, square(0), "WALL")
    outline(space, square(10), "Section B")
    sheet = document.layout("Layout1")
    views = [sheet.add_viewport((5, 5), (10, 10), (10, 10), 20) for _ in range(2)]
    views[0].freeze("Section B")
    document.layers.add("Section B")
    assert len(read(document, tmp_path).blocks) == 2
    views[1].freeze("SECTION B")
    assert (
        'layer "Section B" is frozen in every viewport and shown in model space; freeze it there too'
        in refused(document, tmp_path)
    )
    assert len(read(document, tmp_path, layers={"section b": STONE}).blocks) == 2
