"""PLY files in every dialect, against an independent library and rows written by hand."""

import numpy as np
import plyfile
import pytest

from r3gw.files.ply import read_vertices, write_vertices

ROWS = np.array(
    [(0.5, -2.0, 1), (np.float32(1 / 3), 7.0, 0)], [("x", "<f4"), ("y", "<f4"), ("s", "u1")]
)
FACES = np.array([([0, 1, 1], 7), ([1, 0, 1], 9)], [("vertex_indices", "i4", (3,)), ("tag", "u1")])


def same(found, expected=ROWS):
    assert found.dtype.names == expected.dtype.names
    for name in expected.dtype.names:
        assert np.array_equal(found[name], expected[name])


def test_an_independent_reader_agrees(tmp_path):
    write_vertices(tmp_path / "a.ply", ROWS, ["one fact", "another"])
    found = plyfile.PlyData.read(str(tmp_path / "a.ply"))
    assert found.comments == ["one fact", "another"]
    assert found.byte_order == "<"
    assert found["vertex"].data.dtype == ROWS.dtype
    assert found["vertex"].data.tobytes() == ROWS.tobytes()


@pytest.mark.parametrize("faces_first", [True, False])
@pytest.mark.parametrize("form", ["ascii", "<", ">"])
def test_what_an_independent_writer_wrote_is_read(tmp_path, form, faces_first):
    vertex = plyfile.PlyElement.describe(ROWS, "vertex")
    faces = plyfile.PlyElement.describe(
        FACES, "face", len_types={"vertex_indices": "u1"}, val_types={"vertex_indices": "i4"}
    )
    plain = plyfile.PlyElement.describe(np.array([(3.0,)], [("focal", "f8")]), "camera")
    elements = [faces, plain, vertex] if faces_first else [vertex, plain, faces]
    path = tmp_path / "a.ply"
    data = plyfile.PlyData(
        elements,
        text=form == "ascii",
        byte_order="=" if form == "ascii" else form,
        comments=["a fact"],
        obj_info=["num_cols 3"],
    )
    data.write(str(path))
    rows, comments = read_vertices(path)
    assert comments == ["a fact"]
    same(rows)


@pytest.mark.parametrize("form", ["ascii", "<", ">"])
def test_lists_inside_vertices_are_passed_over(tmp_path, form):
    element = plyfile.PlyElement.describe(FACES, "vertex")
    path = tmp_path / "a.ply"
    text = form == "ascii"
    plyfile.PlyData([element], text=text, byte_order="=" if text else form).write(str(path))
    rows, _ = read_vertices(path)
    assert rows.dtype.names == ("tag",)
    assert rows["tag"].tolist() == [7, 9]


@pytest.mark.parametrize("line_end", [b"\n", b"\r\n", b"\r"])
@pytest.mark.parametrize("names", [("float", "uchar"), ("float32", "uint8")])
def test_line_ends_and_both_families_of_type_names(tmp_path, line_end, names):
    real, small = (name.encode() for name in names)
    lines = [
        *(b"ply", b"format binary_little_endian 1.0", b"comment by \xe9me", b"obj_info x"),
        *(b"element vertex 2", b"property " + real + b" x", b"property " + real + b" y"),
        *(b"property " + small + b" s", b"end_header", b""),
    ]
    path = tmp_path / "a.ply"
    path.write_bytes(line_end.join(lines) + ROWS.tobytes())
    rows, _ = read_vertices(path)
    same(rows)


@pytest.mark.parametrize(
    ("written", "rewritten"),
    [
        (b"ply\n", b"\xef\xbb\xbfply\n"),
        (b"ply\n", b"PLY \n"),
        (b"end_header\n", b"end_header \t\n"),
        (b"float y\n", b"float y\nproperty char scalar_GPS time #1\n"),
    ],
)
def test_headers_of_editors_and_scanners(tmp_path, written, rewritten):
    path = tmp_path / "a.ply"
    write_vertices(path, ROWS, [])
    data = path.read_bytes().replace(written, rewritten)
    if b"GPS" in rewritten:
        more = np.array([(x, y, 5, s) for x, y, s in ROWS.tolist()], "<f4,<f4,i1,u1")
        data = data.replace(ROWS.tobytes(), more.tobytes())
    path.write_bytes(data)
    rows, _ = read_vertices(path)
    assert rows[["x", "y", "s"]].tolist() == ROWS.tolist()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda _: b"", "no PLY header"),
        (lambda data: data.replace(b"end_header", b"end_of_it"), "no PLY header"),
        (lambda data: data.replace(b"little", b"middle"), "unexpected line 'format binary_middle"),
        (lambda data: data.replace(b"float y", b"half y"), "unexpected line 'property half y'"),
        (lambda data: data[:-1], "17 bytes of rows, 18 expected"),
        (lambda data: data + b"xx", "20 bytes of rows, 18 expected"),
        (lambda data: data.replace(b"vertex 2", b"vertex 99999999999999"), "bytes of rows"),
        (lambda data: data.replace(b"element vertex", b"element corner"), "no element 'vertex'"),
        (lambda data: data.replace(b" y\n", b" x\n"), "occurs more than once"),
    ],
)
def test_broken_files_are_refused(tmp_path, change, message):
    path = tmp_path / "a.ply"
    write_vertices(path, ROWS, [])
    path.write_bytes(change(path.read_bytes()))
    with pytest.raises(ValueError, match=message):
        read_vertices(path)


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("0.5 -2", "a row has 2 values, 3 expected"),
        ("0.5 -2 1\n1 2 3", "2 rows, 1 expected"),
        ("", "0 rows, 1 expected"),
        ("0.5 x 1", "could not convert"),
        ("0.5 -2 300", "the property 's' holds values that its type cannot"),
    ],
)
def test_broken_text_is_refused(tmp_path, rows, message):
    header = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
    path = tmp_path / "a.ply"
    path.write_text(header + "property uchar s\nend_header\n" + rows)
    with pytest.raises(ValueError, match=message):
        read_vertices(path)
