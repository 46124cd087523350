"""Reader of anybody's own photos: SIFT, matching and incremental mapping by pycolmap.

Every step is seeded, and mapping runs on one thread, because Ceres adds up in the order in which
threads finish: the same photos and seed give the same scene. Photos need no EXIF; where it tells
a focal length, mapping starts from it, and its orientation is baked in first.
"""

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
from r3gw.imaging.files import read_rgb, write_image
from r3gw.importing.folders import MASK_FOLDERS, mask_files
from r3gw.importing.named_files import pictures_by_key
from r3gw.importing.orientation import upright_mask
from r3gw.importing.readers.colmap_model import from_reconstruction
from r3gw.importing.reconstruction.pycolmap_log import quiet
from r3gw.importing.reconstruction.registration import ADVICE, Mapped, registration_report
from r3gw.importing.reconstruction.video import extract_frames
from r3gw.importing.settings import PhotosScene
from r3gw.importing.source import MaskKind, SourceMask, SourceScene, SourceView

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
            focal_lengths = work.bake_orientation(photos)
            if not is_video:
                work.bake_masks(photos_folder, photos)
            mode = pycolmap.CameraMode.SINGLE if is_video else pycolmap.CameraMode.PER_IMAGE
            work.extract_features(focal_lengths, mode)
            work.match(settings.matching or ("sequential" if is_video else "exhaustive"))
            mapped = work.map()
            found = work.read(mapped.chosen)
            write_json(target / "sfm_report.json", registration_report(photos, mapped, found))
        yield found


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
    def database(self) -> Path:
        """Features and matches."""
        return self.folder / "database.db"

    def bake_orientation(self, photos: Mapping[str, Path]) -> dict[str, float]:
        """Write every photo upright as PNG; return the focal lengths (px) that EXIF tells."""
        focal_lengths = {}
        for path in tqdm(photos.values(), desc="reading photos", unit="photo", leave=False):
            write_image(self.photos / f"{path.stem}.png", read_rgb(path))
            camera = pycolmap.infer_camera_from_image(path)
            if camera.has_prior_focal_length:
                focal_lengths[f"{path.stem}.png"] = float(camera.mean_focal_length())
        return focal_lengths

    def bake_masks(self, folder: Path, photos: Mapping[str, Path]) -> None:
        """Write every mask upright, white = True, and what features may be taken from."""
        given = {kind: mask_files(folder / name) for kind, (name, _) in MASK_FOLDERS.items()}
        if not any(given.values()):
            return
        for key, photo in photos.items():
            # pycolmap leaves out photos without a mask, so every photo gets one.
            keep: NDArray[np.bool_] = np.ones(read_rgb(photo).shape[:2], dtype=np.bool_)
            for kind in (kind for kind, files in given.items() if key in files):
                mask = upright_mask(given[kind][key], photo)
                mask = mask if MASK_FOLDERS[kind][1] else ~mask
                path = self.folder / "masks" / kind / f"{photo.stem}.png"
                write_image(path, mask)
                self.masks.setdefault(photo.stem, {})[kind] = SourceMask(path)
                keep &= ~mask if kind == "is_sky" else mask
            write_image(self.folder / "keep" / f"{photo.stem}.png.png", keep)

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
        if (self.folder / "keep").is_dir():
            reader.mask_path = self.folder / "keep"
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
