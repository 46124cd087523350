"""NumPy archives: what does not fit, is damaged or would run code is refused in a sentence."""

import io
import pickle
import zipfile

import numpy as np
import pytest

from r3gw.files import InputError
from r3gw.files.npz import Array, read_npz, write_npz

XYZ = np.arange(6, dtype=np.float32).reshape(2, 3)
WANTED = {"xyz": Array(np.float32, (None, 3))}


def test_round_trip(tmp_path):
    write_npz(tmp_path / "a.npz", {"xyz": XYZ, "other": np.zeros(3)})
    assert np.array_equal(read_npz(tmp_path / "a.npz", WANTED, "again")["xyz"], XYZ)


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"other": XYZ}, r"lacks the array 'xyz'; import again"),
        ({"xyz": XYZ[:, :2]}, r"the array 'xyz' \(2x2, float32\) is not what it should be"),
        ({"xyz": XYZ.astype(np.float64)}, r"\(2x3, float64\)"),
        ({"xyz": np.full((1, 3), np.nan, np.float32)}, r"NaN or infinity; import again"),
        ({"xyz": np.array([[{}]], dtype=object)}, r"is damaged \(Object arrays"),
    ],
)
def test_other_contents_are_refused(tmp_path, values, sentence):
    np.savez(tmp_path / "a.npz", **values)
    with pytest.raises(InputError, match=sentence):
        read_npz(tmp_path / "a.npz", WANTED, "import again")


def test_damaged_and_swollen_archives_are_refused(tmp_path):
    path = tmp_path / "a.npz"
    write_npz(path, {"xyz": XYZ})
    whole = path.read_bytes()
    cases = [whole[:40], b"", b"PK\x03\x04" + bytes(50), pickle.dumps(XYZ)]
    for data in cases:
        path.write_bytes(data)
        with pytest.raises(InputError, match=r"a\.npz: is damaged \(.*\); import again"):
            read_npz(path, WANTED, "import again")
    huge = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        huge, {"descr": "<f4", "fortran_order": False, "shape": (10**10, 3)}
    )
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("xyz.npy", huge.getvalue())
    with pytest.raises(InputError, match=r"is damaged"):
        read_npz(path, WANTED, "import again")
