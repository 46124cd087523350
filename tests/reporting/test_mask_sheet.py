"""The contact sheet of masks: what is tinted, and how many photos are shown."""

import numpy as np
from support import nerf_osr_layout

from r3gw.imaging.files import read_rgb
from r3gw.importing.settings import NerfOsrScene
from r3gw.importing.stage import import_scene
from r3gw.masks.found import save_found
from r3gw.masks.settings import MaskSources
from r3gw.masks.stage import make_masks
from r3gw.reporting.figures.mask_sheet import mask_sheet, occluder_sheet, overlay
from r3gw.reporting.figures.style import look, save
from r3gw.scene import load_scene


def test_overlay_tints_what_the_masks_say():
    photo = np.full((4, 6, 3), 100, np.uint8)
    is_sky = np.zeros((4, 6), np.bool_)
    is_sky[:2] = True
    is_valid = np.ones((4, 6), np.bool_)
    is_valid[:, 0] = False
    shown = overlay(photo, is_valid, is_sky)
    assert (shown[2:, 1:] == 100).all()
    assert (shown[:2, 1:] == (178, 50, 120)).all()  # half of (255, 0, 140)
    assert (shown[:, 0] == (178, 150, 50)).all()  # half of (255, 200, 0), also on sky
    assert (photo == 100).all()


def test_sheet_is_the_same_twice_and_shows_sky_and_occluders(tmp_path):
    place = nerf_osr_layout.build(tmp_path / "place")
    settings = NerfOsrScene(format="nerf-osr", path=".")
    import_scene("place", settings, place.folder, tmp_path / "scene", num_threads=1)
    make_masks(tmp_path / "scene", tmp_path / "masks", MaskSources())
    for target in ("a", "b"):
        mask_sheet("place", tmp_path / "scene", tmp_path / "masks", tmp_path / target)
    first, second = (tmp_path / t / "place_masks.png" for t in ("a", "b"))
    assert first.read_bytes() == second.read_bytes()
    sheet = read_rgb(first).astype(int)
    red, green, blue = sheet[..., 0], sheet[..., 1], sheet[..., 2]
    is_pink = (red - green > 60) & (blue - green > 60)
    is_yellow = (red - blue > 60) & (green - blue > 30)
    assert 0.15 < is_pink.mean() < 0.4
    assert 0.05 < is_yellow.mean() < 0.2


def test_a_sheet_of_a_run_adds_what_it_found_in_training_photos(tmp_path):
    place = nerf_osr_layout.build(tmp_path / "place")
    settings = NerfOsrScene(format="nerf-osr", path=".")
    import_scene("place", settings, place.folder, tmp_path / "scene", num_threads=1)
    make_masks(tmp_path / "scene", tmp_path / "masks", MaskSources())
    folders = tmp_path / "scene", tmp_path / "masks"
    with look():
        assert occluder_sheet(*folders, tmp_path / "run") is None
        views = load_scene(tmp_path / "scene").split("train")
        whole = np.ones((views[0].height, views[0].width), np.bool_)
        yellow = {}
        for name, mask in (("nothing", ~whole), ("all", whole)):
            save_found(tmp_path / name, {views[0].name: mask})
            figure = occluder_sheet(*folders, tmp_path / name)
            save(figure, tmp_path / f"{name}.png", as_pdf=False)
            red, green, blue = np.moveaxis(read_rgb(tmp_path / f"{name}.png").astype(int), -1, 0)
            yellow[name] = ((red - blue > 60) & (green - blue > 30)).mean()
    assert yellow["all"] > yellow["nothing"] + 0.05
