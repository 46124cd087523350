"""Which photos are held out of training: every n-th, by name, or as the source says."""

import json

import pytest
import yaml
from support import dots

from r3gw.files import InputError
from r3gw.importing.hold_out import every
from r3gw.importing.settings import PhotosScene, parse_scene
from r3gw.importing.stage import import_scene


@pytest.fixture
def colmap(tmp_path):
    """A COLMAP folder of photos 0.png, 1.png, ... without a split."""
    dots.colmap(tmp_path / "colmap")
    (tmp_path / "colmap" / "dots_split.csv").unlink(missing_ok=True)
    return tmp_path / "colmap"


def imported(folder, hold_out):
    entry = parse_scene({"format": "colmap", "path": ".", "hold_out": hold_out}, "test")
    target = folder.parent / "scene"
    scene = import_scene("dots", entry, folder, target, num_threads=1)
    notes = json.loads((target / "sfm_report.json").read_text())["notes"]
    return [view.name for view in scene.views], [view.name for view in scene.split("test")], notes


def test_one_of_every_so_many_from_the_middle_of_each_stretch():
    assert every(8, [f"{i}" for i in range(21)]) == ["4", "12", "20"]
    assert every(3, ["a", "b", "c", "d"]) == ["b"]
    assert every(2, ["a", "b", "c", "d"]) == ["b", "d"]
    assert every(5, ["a", "b", "c", "d"]) == []


def test_photos_are_held_out_and_named_in_the_report(colmap):
    names, test, notes = imported(colmap, 2)
    assert test == names[1::2]
    assert len(test) < len(names)
    assert notes[-1] == (
        f"{len(test)} of {len(names)} photos held out of training, to be scored: "
        + ", ".join(f"{name}.png" for name in test)
    )


def test_names_may_lack_folder_and_suffix(colmap):
    names, _, _ = imported(colmap, None)
    _, test, _ = imported(colmap, [names[0], f"{names[2]}.JPG"])
    assert test == [names[0], names[2]]


def test_too_few_photos_are_all_trained_on_and_that_is_said(colmap):
    names, test, notes = imported(colmap, 100)
    assert test == []
    assert notes[-1] == (
        f"no photo is held out to be scored: 'hold_out: 100' takes one of every 100, and there are "
        f"{len(names)}"
    )


def test_nothing_is_held_out_unasked_but_of_photos(colmap):
    assert imported(colmap, None)[1:] == ([], [])
    assert PhotosScene(format="photos", path=".").hold_out == 8


def test_a_name_of_no_photo_is_refused(colmap):
    with pytest.raises(InputError, match=r"'hold_out' names nobody, which is no photo"):
        imported(colmap, ["nobody"])


def test_photos_to_train_on_must_be_left(colmap):
    names, _, _ = imported(colmap, None)
    with pytest.raises(InputError, match=r"leaves 1 of \d+ photos to train on.*hold fewer out"):
        imported(colmap, names[1:])


def test_a_split_of_the_source_is_not_overruled(colmap):
    names, _, _ = imported(colmap, None)
    lines = [f"{name}.png;{'test' if i == 0 else 'train'}\n" for i, name in enumerate(names)]
    (colmap / "dots_split.csv").write_text("filename;split\n" + "".join(lines))
    assert imported(colmap, None)[1] == names[:1]
    with pytest.raises(InputError, match=r"has a split of its own.*take one of the two away"):
        imported(colmap, 2)


@pytest.mark.parametrize("value", [1, [], "all"])
def test_what_holds_nothing_out_is_no_value(value):
    with pytest.raises(InputError, match="hold_out"):
        parse_scene({"format": "photos", "path": ".", "hold_out": value}, "test")


def test_names_that_yaml_reads_as_numbers_are_asked_for_in_quotes():
    """10265353_38 is the number 1026535338 in YAML."""
    value = yaml.safe_load("[10265353_38]")
    with pytest.raises(InputError, match=r"hold_out.*put '1026535338' and others .* into quotes"):
        parse_scene({"format": "photos", "path": ".", "hold_out": value}, "test")
    value = yaml.safe_load("['10265353_38']")
    entry = parse_scene({"format": "photos", "path": ".", "hold_out": value}, "test")
    assert entry.hold_out == ["10265353_38"]
