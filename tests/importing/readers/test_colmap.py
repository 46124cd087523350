"""COLMAP folders as people have them: several models, odd names, far coordinates, damaged files."""

import json
import shutil

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support import dots
from support.made_up_place import FOCAL_PX, SIZE, place_photo

from r3gw.files import InputError
from r3gw.importing.formats import reader_of
from r3gw.importing.settings import ColmapScene
from r3gw.importing.stage import import_scene
from r3gw.scene import load_points

WITHIN_PX = 0.5
UTM, ECEF = (691_000.0, 5_334_000.0, 520.0), (4_177_000.0, 855_000.0, 4_728_000.0)
RIG = [f"rig/{side}/{number:04d}.png" for side in ("left", "right") for number in (1, 2)]


def imported(folder, **settings):
    target = folder.parent / "scene"
    entry = ColmapScene(format="colmap", path=".", **settings)
    scene = import_scene("dots", entry, folder, target, num_threads=1)
    report = json.loads((target / "sfm_report.json").read_text())
    return scene, target, report


def assert_in_place(scene, target):
    xyz = load_points(target).xyz.astype(np.float64)
    assert max(dots.errors_px(scene, xyz, target)) < WITHIN_PX


def edit(path, change):
    path.write_text(change(path.read_text()))


@pytest.mark.parametrize("offset", [UTM, ECEF], ids=["UTM", "ECEF"])
@pytest.mark.parametrize("text", [True, False], ids=["text", "binary"])
def test_coordinates_of_maps_keep_their_precision(tmp_path, offset, text):
    dots.colmap(tmp_path / "colmap", offset=offset, text=text)
    scene, target, _ = imported(tmp_path / "colmap")
    assert_in_place(scene, target)
    # The way back leads to the map.
    back = scene.source_from_scene
    centre = back.scale * (back.rotation @ scene.views[0].camera.centre) + back.translation
    pose = dots.pose(dots.TURNS_DEG[0])
    expected = -pose[:3, :3].T @ pose[:3, 3] + np.array(offset)
    np.testing.assert_allclose(centre.numpy(), expected, rtol=0, atol=1e-6)


def test_coordinates_that_single_precision_cannot_carry_need_an_extent(tmp_path):
    dots.colmap(tmp_path / "colmap", offset=UTM)
    with pytest.raises(InputError, match=r"moves by .* px in the photos; set 'extent'"):
        imported(tmp_path / "colmap", extent=None)
    dots.colmap(tmp_path / "near", offset=(30.0, -20.0, 10.0))
    assert_in_place(*imported(tmp_path / "near", extent=None)[:2])


def test_the_largest_model_is_taken_and_the_others_are_named(tmp_path, caplog):
    made = dots.colmap(tmp_path / "colmap", images=[0, 1])
    values = dots.parameters("PINHOLE")
    whole = dots.reconstruction(made, "PINHOLE", values, images=[0, 1, 2])
    dots.write_model(whole, tmp_path / "colmap" / "sparse" / "1", text=False)
    scene, target, report = imported(tmp_path / "colmap")
    assert [view.path for view in scene.views] == made.names[:3]
    assert_in_place(scene, target)
    assert report["not_registered"] == {made.names[3]: "not in the model"}
    assert (report["photos"], report["format"]) == (4, "colmap")
    assert "sparse/1 with 3 images; left out: sparse/0 with 2" in report["notes"][0]
    assert "sparse/0 with 2" in caplog.text
    assert "1 of 4 photos are left out: 1 not in the model (photo_3.png)" in caplog.text


@pytest.mark.parametrize("place", ["sparse", "."])
def test_a_model_directly_in_sparse_or_beside_the_photos(tmp_path, place):
    dots.colmap(tmp_path / "colmap")
    for path in (tmp_path / "colmap" / "sparse" / "0").iterdir():
        path.rename(tmp_path / "colmap" / place / path.name)
    (tmp_path / "colmap" / "sparse" / "0").rmdir()
    assert_in_place(*imported(tmp_path / "colmap")[:2])


def without_point_lines(text):
    return "".join(line + "\n" for line in text.splitlines() if line.strip())


@pytest.mark.parametrize(
    "change",
    [
        without_point_lines,
        lambda text: text.replace("\n", "\r\n"),
        lambda text: "\ufeff" + text,
        lambda text: text.replace("\n\n", "\n10.5 20 -1 30 40.25 7\n"),
        lambda text: text.replace("\n\n", "\n234 20 1 30 40 7 3 4 5 6 7 8\n"),
        lambda text: text + "\n\n",
    ],
    ids=["no point lines", "CRLF", "BOM", "points", "whole numbers", "blank lines"],
)
def test_dialects_of_images_txt(tmp_path, change):
    dots.colmap(tmp_path / "colmap")
    edit(tmp_path / "colmap" / "sparse" / "0" / "images.txt", change)
    scene, target, _ = imported(tmp_path / "colmap")
    assert len(scene.views) == 4
    assert_in_place(scene, target)


@pytest.mark.parametrize("text", [True, False], ids=["text", "binary"])
def test_names_with_blanks_dots_and_accents(tmp_path, text):
    names = ["plan A (0).png", "v1.2.final.png", "façade.png", "it's {x} $HOME.png"]
    dots.colmap(tmp_path / "colmap", names=names, text=text)
    # macOS decomposes accents in file names.
    images = tmp_path / "colmap" / "images"
    (images / "façade.png").rename(images / "fac\u0327ade.png")
    scene, target, _ = imported(tmp_path / "colmap")
    assert sorted(view.path for view in scene.views) == sorted(names)
    assert {view.name for view in scene.views} == {name[:-4] for name in names}
    assert_in_place(scene, target)


def test_photos_of_a_rig_have_equal_stems(tmp_path):
    dots.colmap(tmp_path / "colmap", names=RIG)
    folder = tmp_path / "colmap"
    rows = ["filename;split", *(f"{name};train" for name in RIG[:3]), f"{RIG[3]};test"]
    (folder / "place_split.csv").write_text("\n".join(rows))
    for number, name in enumerate(RIG):
        mask = np.full(dots.SIZE[::-1], 255, np.uint8)
        mask[:, : 10 * (number + 1)] = 0
        path = folder / "masks" / name.removeprefix("rig/")
        path.parent.mkdir(parents=True, exist_ok=True)
        cv2.imwrite(str(path), mask)
    scene, target, _ = imported(folder)
    assert [view.name for view in scene.views] == [
        "left_0001",
        "left_0002",
        "right_0001",
        "right_0002",
    ]
    assert [view.path for view in scene.views] == RIG
    assert [view.split for view in scene.views] == ["train", "train", "train", "test"]
    assert_in_place(scene, target)
    for number, view in enumerate(scene.views):
        mask = cv2.imread(str(target / "given" / "is_valid" / f"{view.name}.png"), 0)
        assert (mask == 0).all(axis=0).sum() == 10 * (number + 1)


def test_thumbnails_folders_and_hidden_files_are_no_photos(tmp_path):
    dots.colmap(tmp_path / "colmap")
    images = tmp_path / "colmap" / "images"
    for place in ("@eaDir/photo_0.png", "__MACOSX", ".thumbnails", "folder.png"):
        (images / place).mkdir(parents=True)
        shutil.copy(images / "photo_0.png", images / place / "photo_0.png")
    (images / "folder.png" / "photo_0.png").unlink()
    (images / "._photo_1.png").write_bytes(b"resource fork")
    (images / "notes.md").write_text("north side")
    scene, _, report = imported(tmp_path / "colmap")
    assert len(scene.views) == report["photos"] == 4
    assert report["notes"] == ["one file beside the photos not read: 1 no picture (.md); notes.md"]
    facts = reader_of(ColmapScene(format="colmap", path="."), tmp_path / "colmap").facts()
    assert (facts["photos"], facts["model"]) == ("4", "sparse/0, 4 images")


def test_a_mask_that_fits_several_photos_is_refused(tmp_path):
    dots.colmap(tmp_path / "colmap", names=RIG)
    (tmp_path / "colmap" / "masks").mkdir()
    cv2.imwrite(str(tmp_path / "colmap" / "masks" / "0001.png"), np.zeros((9, 9), np.uint8))
    with pytest.raises(InputError, match=r"masks: 0001\.png fits several photos \(rig/left/0001"):
        imported(tmp_path / "colmap")


@pytest.mark.slow
def test_known_poses_without_points_are_triangulated(tmp_path):
    """COLMAP's own workflow for known cameras: an empty points3D.txt."""
    folder, lines = tmp_path / "colmap", []
    (folder / "images").mkdir(parents=True)
    (folder / "sparse").mkdir()
    offset = np.array(UTM)
    for number, azimuth in enumerate(np.linspace(-20, 20, 4)):
        angle = np.radians(azimuth)
        centre = np.array([4 * np.sin(angle), -0.2 * number, 5 - 5 * np.cos(angle)])
        turn = Rotation.from_euler("YX", [-azimuth, 4], degrees=True).inv()
        image = place_photo(turn.as_matrix(), centre)
        cv2.imwrite(str(folder / "images" / f"{number}.png"), image)
        x, y, z, w = turn.as_quat()
        shift = -turn.as_matrix() @ (centre + offset)
        words = [number + 1, w, x, y, z, *shift, 1, f"{number}.png"]
        lines.append(" ".join(map(str, words)) + "\n\n")
    (folder / "sparse" / "images.txt").write_text("".join(lines))
    camera = f"1 PINHOLE {SIZE[0]} {SIZE[1]} {FOCAL_PX} {FOCAL_PX} {SIZE[0] / 2} {SIZE[1] / 2}\n"
    (folder / "sparse" / "cameras.txt").write_text(camera)
    (folder / "sparse" / "points3D.txt").write_text("")
    scene, target, report = imported(folder, up="given")
    xyz = load_points(target).xyz
    assert len(xyz) > 150
    assert "points: " in report["notes"][0]
    # In the map's frame they lie on the walls: z = 6 - 0.75 |x|, or on the ground y = 1.
    back = scene.source_from_scene
    found = back.scale * xyz.astype(np.float64) @ back.rotation.numpy().T + back.translation.numpy()
    x, y, z = (found - offset).T
    walls = np.minimum(np.abs(0.6 * x - 0.8 * (z - 6)), np.abs(0.8 * x + 0.6 * (z - 6)))
    walls = np.minimum(walls, np.abs(-0.6 * x - 0.8 * (z - 6)))
    assert np.median(np.minimum(walls, np.abs(y - 1))) < 0.05
