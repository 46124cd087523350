"""Renders are found as 3DGS, gsplat, nerfstudio and LumiGauss write them, and score the same."""

import numpy as np
import pytest
from click.testing import CliRunner

from r3gw.cli.group import cli
from r3gw.cli.score import score as _registered  # noqa: F401
from r3gw.evaluation.scoring import score_folders
from r3gw.files import InputError
from r3gw.imaging.files import write_image

NAMES = ("left_0001", "left_0002", "right_0001")


@pytest.fixture(scope="module")
def pictures():
    """A photo, a render and a mask by name; every one differs from the others."""
    random = np.random.default_rng(0)
    photos = {name: random.integers(0, 256, (16, 20, 3), np.uint8) for name in NAMES}
    renders = {name: photos[name] // 2 + 20 * i for i, name in enumerate(NAMES)}
    masks = {name: np.arange(20)[None] * np.ones((16, 1)) >= 3 * i for i, name in enumerate(NAMES)}
    return photos, renders, masks


@pytest.fixture
def plain(tmp_path, pictures):
    """Folders of photos, renders and masks by name, and the scores of every render."""
    for kind, found in zip(("photos", "renders", "masks"), pictures, strict=True):
        for name, picture in found.items():
            write_image(tmp_path / f"plain/{kind}/{name}.png", picture)
    folder = tmp_path / "plain"
    return folder, score_folders(folder / "renders", folder / "photos", folder / "masks")


def write_3dgs(folder, photos, renders, with_gt=True):
    for part, iteration in (("test", 7000), ("test", 30000), ("train", 30000)):
        for i, name in enumerate(NAMES):
            here = folder / part / f"ours_{iteration}"
            is_final = (part, iteration) == ("test", 30000)
            render = renders[name] if is_final else np.zeros_like(renders[name])
            write_image(here / f"renders/{i:05d}.png", render)
            if with_gt:
                write_image(here / f"gt/{i:05d}.png", photos[name])


def write_nerfstudio_render(folder, photos, renders):
    for name in NAMES:
        write_image(folder / f"test/rgb/{name}.png", renders[name])
        write_image(folder / f"test/gt-rgb/{name}.png", photos[name])
        write_image(folder / f"train/rgb/{name}.png", renders[name] * 0)
        write_image(folder / f"test/depth/{name}.png", renders[name] * 0)


def write_nerfstudio_eval(folder, photos, renders):
    for i, name in enumerate(NAMES):
        both = np.concatenate([photos[name], renders[name]], axis=1)
        write_image(folder / f"eval_img_{i:04d}.png", both)


def write_gsplat(folder, photos, renders):
    for step, factor in ((6999, 0), (29999, 1)):
        for i, name in enumerate(NAMES):
            both = np.concatenate([photos[name], renders[name] * factor], axis=1)
            write_image(folder / f"renders/val_step{step}_{i:04d}.png", both)
    write_image(folder / "renders/compress_step29999_0000.png", renders[NAMES[0]])


LAYOUTS = {
    "3dgs": write_3dgs,
    "nerfstudio render": write_nerfstudio_render,
    "nerfstudio eval": write_nerfstudio_eval,
    "gsplat": write_gsplat,
}


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("has_truth", [False, True])
def test_every_layout_gives_the_scores_of_plain_folders(
    tmp_path, pictures, plain, layout, has_truth
):
    """With masks by the photos' names, for renders that are only numbered, too."""
    folder, expected = plain
    LAYOUTS[layout](tmp_path / "theirs", *pictures[:2])
    truth = folder / "photos" if has_truth else None
    scored = score_folders(tmp_path / "theirs", truth, folder / "masks")
    assert [each.masked for each in scored] == [each.masked for each in expected]
    assert [each.num_pixels for each in scored] == [each.num_pixels for each in expected]


@pytest.mark.parametrize("inside", ["test", "test/ours_30000", "test/ours_30000/renders"])
def test_any_folder_of_a_layout_will_do(tmp_path, pictures, plain, inside):
    write_3dgs(tmp_path / "theirs", *pictures[:2])
    scored = score_folders(tmp_path / "theirs" / inside, None, plain[0] / "masks")
    assert [each.masked for each in scored] == [each.masked for each in plain[1]]


def test_without_photos_their_folder_is_asked_for(tmp_path, pictures, plain):
    write_3dgs(tmp_path / "theirs", *pictures[:2], with_gt=False)
    with pytest.raises(InputError, match=r"theirs: holds no photos beside the renders.*--truth"):
        score_folders(tmp_path / "theirs", None, None)
    scored = score_folders(tmp_path / "theirs", plain[0] / "photos", plain[0] / "masks")
    assert [each.masked for each in scored] == [each.masked for each in plain[1]]


def test_numbers_that_cannot_be_told_apart_are_refused(tmp_path, pictures, plain):
    write_3dgs(tmp_path / "theirs", *pictures[:2])
    folder = plain[0] / "photos"
    write_image(folder / "another.png", np.zeros((16, 20, 3), np.uint8))
    with pytest.raises(InputError, match="holds 4 photos for 3 renders that are only numbered"):
        score_folders(tmp_path / "theirs", folder, None)


def test_names_are_never_paired_in_order(plain):
    folder = plain[0]
    (folder / "renders/left_0001.png").rename(folder / "renders/left_0009.png")
    with pytest.raises(InputError, match="photos: holds no photo named left_0009"):
        score_folders(folder / "renders", folder / "photos", None)


def test_a_picture_that_cannot_be_halved_is_named(tmp_path):
    write_image(tmp_path / "eval_img_0000.png", np.zeros((4, 5, 3), np.uint8))
    with pytest.raises(InputError, match=r"eval_img_0000\.png: is 5 px wide"):
        score_folders(tmp_path, None, None)


def test_the_command_takes_a_program_s_folder_alone(tmp_path, pictures):
    write_gsplat(tmp_path, *pictures[:2])
    done = CliRunner().invoke(cli, ["score", "--renders", str(tmp_path)])
    assert done.exit_code == 0, done.output
    assert done.output.count("\n| 000") == 3
