"""Which photos are matched: all, those alike, neighbours in space or in order."""

from pathlib import Path

import cv2
import numpy as np
import pycolmap
import pytest
from scipy.spatial.transform import Rotation
from support.made_up_place import SIZE, place_photo

from r3gw.files import InputError
from r3gw.importing.reader import Effort
from r3gw.importing.reconstruction import matching
from r3gw.importing.reconstruction.matching import match_photos
from r3gw.importing.reconstruction.prepared import PreparedPhoto
from r3gw.importing.reconstruction.retrieval import alike_pairs


def photos(places):
    return [
        PreparedPhoto(f"{i}.jpg", Path(f"{i:06d}.png"), None, place, {})
        for i, place in enumerate(places)
    ]


@pytest.fixture
def matched(monkeypatch, tmp_path):
    """The pairs that `match_photos` chooses, as numbers, and how it says it chose."""

    def run(places, how, alike=()):
        chosen = []
        monkeypatch.setattr(
            matching, "match_pairs", lambda _database, pairs, _e: chosen.extend(pairs)
        )
        monkeypatch.setattr(matching, "alike_pairs", lambda *_arguments: list(alike))
        said = match_photos(photos(places), tmp_path / "a.db", how, Effort(tmp_path, 1))
        return {(int(first[:6]), int(second[:6])) for first, second in chosen}, said

    return run


def test_few_photos_are_matched_with_all_others(matched):
    pairs, said = matched([None] * 60, None)
    assert (len(pairs), said) == (60 * 59 // 2, "exhaustive, 1770 pairs")


def test_many_photos_are_matched_by_likeness_order_and_place(matched):
    place = [(48.0, 11.0 + 0.001 * i, 0.0) if i < 20 else None for i in range(100)]
    pairs, said = matched(place, None, alike=[("000003.png", "000090.png")])
    assert said == f"retrieval, {len(pairs)} pairs"
    assert len(pairs) < 400
    assert (3, 90) in pairs
    assert {(i, i + 1) for i in range(99)} <= pairs  # order of names
    assert (0, 10) in pairs  # all twenty with a place are among the nearest thirty
    assert (0, 50) not in pairs


def test_sequences_are_matched_as_colmap_matches_them(matched, tmp_path):
    """COLMAP's own generator is the oracle."""
    database = tmp_path / "sequence.db"
    pycolmap.Database.open(database).close()
    with pycolmap.Database.open(database) as opened:
        camera = pycolmap.Camera.create_from_model_name(1, "PINHOLE", 1.0, 9, 9)
        identifier = opened.write_camera(camera)
        for i in range(40):
            opened.write_image(pycolmap.Image(name=f"{i:06d}.png", camera_id=identifier))
        options = pycolmap.SequentialPairingOptions(expand_rig_images=False)
        found = pycolmap.SequentialPairGenerator(options, opened).all_pairs()
    expected = {(min(pair) - 1, max(pair) - 1) for pair in found}
    assert matched([None] * 40, "sequential")[0] == expected


def test_neighbours_in_space_across_the_date_line(matched):
    rng = np.random.default_rng(0)
    metres = rng.uniform(-500, 500, (80, 2))
    degrees = metres / 111_195.0
    longitude = 180 + degrees[:, 0] / np.cos(np.radians(60))
    longitude = np.where(longitude > 180, longitude - 360, longitude)
    place = [(60 + degrees[i, 1], float(longitude[i]), 0.0) for i in range(80)]
    pairs, _ = matched(place, "spatial")
    for i in range(80):
        nearest = np.argsort(np.linalg.norm(metres - metres[i], axis=1))[1:26]
        assert {(min(i, int(j)), max(i, int(j))) for j in nearest} <= pairs


def test_places_that_most_photos_do_not_tell_cannot_choose(matched):
    with pytest.raises(InputError, match="only 1 of 4 photos have it; choose 'retrieval'"):
        matched([(1.0, 2.0, 0.0), None, None, None], "spatial")


@pytest.mark.slow
def test_photos_of_one_place_are_alike(tmp_path):
    """Two places, mirrored textures of each other: nobody is taken for the other place's."""
    (tmp_path / "photos").mkdir()
    for number in range(12):
        azimuth = -15 + 30 * (number // 2) / 5
        angle = np.radians(azimuth)
        centre = np.array([4 * np.sin(angle), -0.1, 5 - 5 * np.cos(angle)])
        turn = Rotation.from_euler("YX", [-azimuth, 4], degrees=True).as_matrix().T
        image = place_photo(turn, centre)
        if number % 2:
            image = cv2.resize(255 - image[::-1, ::-1], SIZE)
        cv2.imwrite(str(tmp_path / "photos" / f"{number:06d}.png"), image)
    database = tmp_path / "a.db"
    pycolmap.Database.open(database).close()
    pycolmap.set_random_seed(0)
    pycolmap.import_images(database, tmp_path / "photos")
    options = pycolmap.FeatureExtractionOptions(num_threads=1, use_gpu=False)
    pycolmap.extract_features(database, tmp_path / "photos", extraction_options=options)
    found = [alike_pairs(database, 4, seed=3) for _ in range(2)]
    assert found[0] == found[1]
    same = [int(first[:6]) % 2 == int(second[:6]) % 2 for first, second in found[0]]
    assert len(same) >= 20
    assert np.mean(same) > 0.9
