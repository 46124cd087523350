"""Files beyond their bounds (docs/reliability.md) are refused by their size alone."""

import time

import pytest

from r3gw.files import InputError
from r3gw.files.arrays import LARGEST_BYTES
from r3gw.files.strict import read_yaml
from r3gw.imaging.decode import read_picture
from r3gw.imaging.exr import read_exr
from r3gw.imaging.radiance import read_radiance

GIB = 1 << 30


@pytest.mark.parametrize(
    ("name", "most_bytes", "read"),
    [
        ("photo.jpg", GIB, read_picture),
        ("sky.exr", GIB, read_exr),
        ("sky.hdr", GIB, read_radiance),
        ("mine.yaml", GIB // 4, read_yaml),
    ],
)
def test_a_file_beyond_its_bound_is_not_even_opened(tmp_path, name, most_bytes, read):
    path = tmp_path / name
    with path.open("wb") as stream:
        stream.truncate(most_bytes + 1)  # a hole: it takes no room
    begin = time.perf_counter()
    with pytest.raises(InputError, match=rf"{name}: is larger than {most_bytes >> 20} MiB"):
        read(path)
    assert time.perf_counter() - begin < 1.0


def test_the_page_states_the_bound_of_models(repository):
    assert LARGEST_BYTES == 8 * 10**9
    assert "Files beyond 8 GB" in (repository / "docs/reliability.md").read_text()
