"""Names inside files may not lead out of their folder."""

import pytest

from r3gw.files import InputError
from r3gw.files.names import inside, leads_outside, stated


@pytest.mark.parametrize(
    "name",
    ["../a.png", "a/../../b.png", "/etc/passwd", "C:\\a.png", "..\\a.png", "", ".", "a\0b", "a/.."],
)
def test_names_that_lead_outside(tmp_path, name):
    assert leads_outside(name)
    with pytest.raises(InputError, match=r"scene\.json: names the file .* which is not below"):
        inside(tmp_path, name, "scene.json")


@pytest.mark.parametrize("name", ["a.png", "a/b.png", "./a.png", "a/../b.png", "a..b.png", "..."])
def test_names_that_stay_inside(tmp_path, name):
    assert inside(tmp_path, name, "scene.json") == tmp_path / name
    assert stated(tmp_path, name, "transforms.json") == tmp_path / name


def test_absolute_paths_of_another_machine_are_found_by_their_tail(tmp_path):
    (tmp_path / "images").mkdir()
    (tmp_path / "images" / "a.png").write_text("x")
    for name in ("/home/alice/scene/images/a.png", "D:\\data\\images\\a.png"):
        assert stated(tmp_path, name, "transforms.json") == tmp_path / "images" / "a.png"
    elsewhere = tmp_path / "elsewhere.png"
    elsewhere.write_text("x")
    assert stated(tmp_path / "images", str(elsewhere), "transforms.json") == elsewhere
    with pytest.raises(InputError, match="not below"):
        stated(tmp_path, "../a.png", "transforms.json")
