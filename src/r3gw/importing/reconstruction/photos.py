"""Reader of anybody's own photos: SIFT, matching and incremental mapping by pycolmap.

Every step is seeded, and mapping runs on one thread, because Ceres adds up in the order in which
threads finish: the same photos and seed give the same scene. Photos need no EXIF; where it tells
a focal length, mapping starts from it, and its orientation is baked in first.
"""

import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pycolmap
from numpy.typing import NDArray
from tqdm import tqdm

from r3gw.files import InputError, write_json
from r3gw.imaging.decode import Picture, read_picture
from r3gw.imaging.files import rgb_of, write_image
from r3gw.importing.focal_length import focal_length_px
from r3gw.importing.folders import MASK_FOLDERS, mask_files
from r3gw.importing.named_files import pictures_by_key
from r3gw.importing.orientation import upright_mask
from r3gw.importing.readers.colmap_model import from_reconstruction
from r3gw.importing.reconstruction.pycolmap_log import quiet
from r3gw.importing.reconstruction.registration import ADVICE, Mapped, registration_report
from r3gw.importing.reconstruction.video import extract_frames
from r3gw.importing.settings import PhotosScene
from r3gw.importing.source import MaskKind, SourceMask, SourceScene, SourceView

Given = Mapping[MaskKind, Mapping[str, Path]]

_LEAST = 3  # photos that a scene needs


@contextmanager
def registered_photos(
    source: Path, target: Path, settings: PhotosScene, *, num_threads: int, seed: int
) -> Iterator[SourceScene]:
    """Register photos, or frames of a video, and yield them in COLMAP's own frame.

    Photos and masks lie upright in a temporary folder in ``target`` while the context is open;
    only ``target/sfm_report.json`` stays.

    Args:
        source: Folder of photos, with masks in ``masks/`` (white = keep) and ``sky_masks/``
            (white = not sky) if there are any; or a video file.
        target: Folder for the report and the temporary files.
        settings: How to match, and how many frames of a video to take.
        num_threads: For features and matching.
        seed: For all random sampling.

    Raises:
        InputError: If a photo is unreadable, two share a stem, or fewer than three register.
    """
    with tempfile.TemporaryDirectory(prefix=".sfm-", dir=target) as folder:
        is_video = source.is_file()
        photos_folder = source
        if is_video:
            photos_folder = Path(folder) / "frames"
            extract_frames(source, photos_folder, settings.video_frames)
        beside = tuple(name for name, _ in MASK_FOLDERS.values())
        photos = pictures_by_key(photos_folder, without=beside)
        if len(photos) < _LEAST:
            count = "one photo is" if len(photos) == 1 else f"{len(photos)} photos are"
            raise InputError(f"{source}: {count} here, but at least {_LEAST} are needed; {ADVICE}")
        work = _Work(Path(folder), source, num_threads, seed)
        with quiet():
            given = {} if is_video else _masks_beside(photos_folder)
            focal_lengths = work.bake(photos, given)
            mode = pycolmap.CameraMode.SINGLE if is_video else pycolmap.CameraMode.PER_IMAGE
            work.extract_features(focal_lengths, mode)
            work.match(settings.matching or ("sequential" if is_video else "exhaustive"))
            mapped = work.map()
            found = work.read(mapped.chosen)
            write_json(target / "sfm_report.json", registration_report(photos, mapped, found))
        yield found


def _masks_beside(folder: Path) -> Given:
    return {kind: mask_files(folder / name) for kind, (name, _) in MASK_FOLDERS.items()}


@dataclass(frozen=True)
class _Work:
    """One run of SfM in a temporary folder."""

    folder: Path
    source: Path
    num_threads: int
    seed: int
    masks: dict[str, dict[MaskKind, SourceMask]] = field(default_factory=dict)

    @property
    def photos(self) -> Path:
        """Photos as pycolmap gets them: upright, without EXIF."""
        return self.folder / "photos"

    @property
    def keep(self) -> Path:
        """Masks of what features may be taken from; no folder if from everywhere."""
        return self.folder / "keep"

    @property
    def database(self) -> Path:
        """Features and matches."""
        return self.folder / "database.db"

    def bake(self, photos: Mapping[str, Path], given: Given) -> dict[str, float]:
        """Write photos and masks upright as PNG; return the focal lengths (px) that EXIF tells.

        Args:
            photos: By key.
            given: Masks by kind and key.
        """
        focal_lengths, is_masked = {}, False
        for key, path in tqdm(photos.items(), desc="reading photos", unit="photo", leave=False):
            picture = read_picture(path)
            upright = picture.upright()
            pixels, keep = rgb_of(upright, path), upright.is_opaque
            if keep is None:
                keep = np.ones(pixels.shape[:2], np.bool_)
            else:
                pixels = np.concatenate([pixels, keep[..., None] * np.uint8(255)], axis=2)
            write_image(self.photos / f"{path.stem}.png", pixels)
            for kind in (kind for kind, files in given.items() if key in files):
                keep = keep & self._bake_mask(kind, given[kind][key], picture, path.stem)
            # pycolmap leaves out photos without a mask, so every photo gets one.
            write_image(self.keep / f"{path.stem}.png.png", keep)
            is_masked = is_masked or not keep.all()
            focal_length = focal_length_px(picture)
            if focal_length is not None:
                focal_lengths[f"{path.stem}.png"] = focal_length
        if not is_masked:
            shutil.rmtree(self.keep)
        return focal_lengths

    def _bake_mask(
        self, kind: MaskKind, file: Path, photo: Picture, stem: str
    ) -> NDArray[np.bool_]:
        """Write one mask upright, white = True; return where features may be taken from."""
        read = upright_mask(file, photo)
        mask = read.is_white if MASK_FOLDERS[kind][1] else ~read.is_white
        path = self.folder / "masks" / kind / f"{stem}.png"
        write_image(path, mask)
        self.masks.setdefault(stem, {})[kind] = SourceMask(path, levels=read.described())
        return ~mask if kind == "is_sky" else mask

    def extract_features(
        self, focal_lengths: Mapping[str, float], mode: pycolmap.CameraMode
    ) -> None:
        """SIFT features of every photo, where its masks allow; ``mode``: who shares a camera."""
        pycolmap.Database.open(self.database).close()
        pycolmap.set_random_seed(self.seed)
        # Entered first and in order, so that identifiers do not depend on which thread is done.
        pycolmap.import_images(self.database, self.photos, camera_mode=mode)
        with pycolmap.Database.open(self.database) as database:
            for image in database.read_all_images():
                if image.name in focal_lengths:
                    camera = database.read_camera(image.camera_id)
                    camera.focal_length = focal_lengths[image.name]
                    camera.has_prior_focal_length = True
                    database.update_camera(camera)
        options = pycolmap.FeatureExtractionOptions(num_threads=self.num_threads, use_gpu=False)
        reader = pycolmap.ImageReaderOptions()
        if self.keep.is_dir():
            reader.mask_path = self.keep
        pycolmap.extract_features(
            self.database,
            self.photos,
            camera_mode=mode,
            reader_options=reader,
            extraction_options=options,
        )

    def match(self, matching: str) -> None:
        """Match all pairs of photos, or neighbours in the order of their names."""
        verification = pycolmap.TwoViewGeometryOptions()
        verification.ransac.random_seed = self.seed
        options = pycolmap.FeatureMatchingOptions(num_threads=self.num_threads, use_gpu=False)
        if matching == "exhaustive":
            pycolmap.match_exhaustive(
                self.database, matching_options=options, verification_options=verification
            )
        else:
            pycolmap.match_sequential(
                self.database, matching_options=options, verification_options=verification
            )

    def map(self) -> Mapped:
        """The model with most photos, and the others."""
        options = pycolmap.IncrementalPipelineOptions(num_threads=1, random_seed=self.seed)
        options.min_model_size = _LEAST
        output = self.folder / "models"
        output.mkdir()
        models = pycolmap.incremental_mapping(self.database, self.photos, output, options)
        largest = max(
            models.values(),
            key=lambda model: (model.num_reg_images(), model.num_points3D()),
            default=None,
        )
        if largest is None or largest.num_reg_images() < _LEAST:
            registered = 0 if largest is None else largest.num_reg_images()
            raise InputError(
                f"{self.source}: only {registered} photos could be registered together, at least "
                f"{_LEAST} are needed; {ADVICE}"
            )
        others = [model for model in models.values() if model is not largest]
        return Mapped(largest, others, self.database)

    def read(self, model: pycolmap.Reconstruction) -> SourceScene:
        """The upright photos with their cameras and lenses, all for training."""
        found = from_reconstruction(model, self.source)
        views = tuple(
            SourceView(
                name=Path(name).stem,
                photo=self.photos / name,
                camera=found.cameras[name],
                split="train",
                masks=self.masks.get(Path(name).stem, {}),
                lens=found.lenses.get(name),
            )
            for name in sorted(found.cameras)
        )
        return SourceScene(views, found.points)
