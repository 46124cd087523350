"""PLY files of Gaussians against an independent reader, and files of other forms refused."""

import numpy as np
import plyfile
import pytest

from r3gw.relight.files.ply_rows import read_rows, write_rows

ROWS = np.array(
    [(0.5, -2.0, 1), (np.float32(1 / 3), 7.0, 0)], [("x", "<f4"), ("y", "<f4"), ("s", "u1")]
)


def test_an_independent_reader_agrees(tmp_path):
    write_rows(tmp_path / "a.ply", ROWS, ["one fact", "another"])
    found = plyfile.PlyData.read(str(tmp_path / "a.ply"))
    assert found.comments == ["one fact", "another"]
    assert found.byte_order == "<"
    assert found["vertex"].data.dtype == ROWS.dtype
    assert found["vertex"].data.tobytes() == ROWS.tobytes()


def test_what_an_independent_writer_wrote_is_read(tmp_path):
    element = plyfile.PlyElement.describe(ROWS, "vertex")
    path = tmp_path / "a.ply"
    plyfile.PlyData([element], byte_order="<", comments=["fact"]).write(str(path))
    rows, comments = read_rows(path)
    assert rows.tobytes() == ROWS.tobytes()
    assert rows.dtype == ROWS.dtype
    assert comments == ["fact"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda _: b"", "no binary little-endian PLY header"),
        (lambda text: text.replace(b"little", b"big"), "no binary little-endian PLY header"),
        (lambda text: text.replace(b"float y", b"double y"), "unexpected line 'property double y'"),
        (lambda text: text[:-1], "17 bytes of rows, 18 expected"),
    ],
)
def test_other_forms_are_refused(tmp_path, change, message):
    path = tmp_path / "a.ply"
    write_rows(path, ROWS, [])
    path.write_bytes(change(path.read_bytes()))
    with pytest.raises(ValueError, match=message):
        read_rows(path)
