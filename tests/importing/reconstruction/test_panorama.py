"""Pictures of all directions are told from ordinary wide ones."""

import cv2
import numpy as np
import pytest

from r3gw.files import InputError
from r3gw.importing.reconstruction.panorama import is_panorama
from r3gw.importing.settings import PhotosScene
from r3gw.importing.stage import import_scene

XMP = (
    b'<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:Description '
    b'GPano:ProjectionType="equirectangular" GPano:FullPanoWidthPixels="400"/></x:xmpmeta>'
)


def all_around(seed=0):
    """An equirectangular picture of smooth random light, with some noise of the sensor."""
    rng = np.random.default_rng(seed)
    theta, phi = np.meshgrid(
        (np.arange(100) + 0.5) * np.pi / 100,
        (np.arange(200) + 0.5) * 2 * np.pi / 200,
        indexing="ij",
    )
    directions = np.stack(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1
    )
    light = sum(np.cos(6 * directions @ rng.normal(size=3) + 3 * k) for k in range(5))
    grey = 128 + 25 * light + rng.normal(0, 1, light.shape)
    return np.repeat(np.clip(grey, 0, 255).astype(np.uint8)[..., None], 3, axis=2)


def wide_crop(seed):
    rng = np.random.default_rng(seed)
    small = rng.integers(0, 255, (12, 24), dtype=np.uint8)
    return np.repeat(cv2.resize(small, (200, 100))[..., None], 3, axis=2)


def saved(path, pixels, xmp=b""):
    data = cv2.imencode(".jpg", pixels)[1].tobytes()
    if xmp:
        payload = b"http://ns.adobe.com/xap/1.0/\0" + xmp
        data = data[:2] + b"\xff\xe1" + (len(payload) + 2).to_bytes(2, "big") + payload + data[2:]
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("seed", range(5))
def test_equirectangular_pictures_are_known_by_their_edges(tmp_path, seed):
    pixels = all_around(seed)
    assert is_panorama(saved(tmp_path / "a.jpg", pixels), pixels)
    cropped = np.ascontiguousarray(pixels[:, 10:-10][:90])
    assert not is_panorama(saved(tmp_path / "b.jpg", cropped), cropped)


@pytest.mark.parametrize("seed", range(20))
def test_an_ordinary_crop_of_two_to_one_is_none(tmp_path, seed):
    pixels = wide_crop(seed)
    assert not is_panorama(saved(tmp_path / "a.jpg", pixels), pixels)


def test_metadata_speak_for_any_shape(tmp_path):
    pixels = wide_crop(0)[:60]
    assert is_panorama(saved(tmp_path / "a.jpg", pixels, XMP), pixels)


def test_a_folder_with_one_is_refused(tmp_path):
    for number in range(3):
        saved(tmp_path / f"{number}.jpg", wide_crop(number))
    saved(tmp_path / "all.jpg", all_around())
    settings = PhotosScene(format="photos", path=".")
    with pytest.raises(InputError, match=r"all\.jpg: is a 360-degree picture .* cube faces"):
        import_scene("a", settings, tmp_path, tmp_path / "scene", num_threads=1)
