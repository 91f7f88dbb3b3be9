"""deformed.dxf: every deformed shape on a layer of its own, at true scale."""

import numpy as np
import pytest
from ezdxf.entitydb import EntityDB
from ezdxf.filemanagement import readfile

from assessment.report.figures.index import shapes, write_deformed
from assessment.results.joint_states import outlines
from tests.support.analysed import analysed
from tests.support.typed import typed


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    path = tmp_path_factory.mktemp("dxf") / "deformed.dxf"
    write_deformed(typed(analysed()), path)
    return path


def test_shapes_come_back_from_the_file_as_they_were(written):
    drawing = readfile(written)
    assert drawing.units == 6  # metres
    assert not drawing.audit().errors
    for layer, shape, _ in shapes(typed(analysed())):
        read = [list(each.vertices()) for each in drawing.modelspace().query(f'LWPOLYLINE[layer=="{layer}"]')]
        for ring, expected in zip(read, shape.rings(range(13)), strict=True):
            np.testing.assert_allclose(ring, expected, atol=1e-9)


def test_layers_name_state_and_shape(written):
    layers = {layer.dxf.name for layer in readfile(written).layers}
    settled = "1_RIGHT_SUPPORT_60_MM"
    assert {"DRAWN", f"{settled}_SETTLED", "0_ORIGINAL_END_PLUS_X", f"{settled}_PEAK_MINUS_X"} <= layers
    assert {"0_ORIGINAL_MECHANISM_PLUS_X", "0_ORIGINAL_HINGES_PLUS_X", "0_ORIGINAL_THRUST_REST"} <= layers
    assert {"0_ORIGINAL_RECORD_1_PEAK", "0_ORIGINAL_RECORD_1_FINAL"} <= layers


def test_the_settled_shape_has_moved_its_support_by_what_was_asked():
    found = {layer: shape for layer, shape, _ in shapes(typed(analysed()))}
    right = [b["support"] for b in analysed()["geometry"]["blocks"]].index("right")
    moved = (
        found["1_RIGHT_SUPPORT_60_MM_SETTLED"].centroids[right] - outlines(typed(analysed())).centroids[right]
    )
    assert moved == pytest.approx([0.06, -0.02], abs=1e-9)


@pytest.mark.parametrize("backwards", [False, True])
def test_bytes_do_not_hang_on_the_order_of_sets(written, tmp_path, monkeypatch, backwards):
    """The order of a set of words is another one in every process."""
    kinds = EntityDB.dxf_types_in_use
    monkeypatch.setattr(EntityDB, "dxf_types_in_use", lambda db: sorted(kinds(db), reverse=backwards))
    write_deformed(typed(analysed()), tmp_path / "again.dxf")
    assert (tmp_path / "again.dxf").read_bytes() == written.read_bytes()
