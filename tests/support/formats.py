"""Converts a scene from the NeRF-OSR layout to other formats, by no code of their readers."""

import json
import shutil
from pathlib import Path

import cv2
import numpy as np
import pycolmap

EXTRA_FILES = ("Thumbs.db", ".DS_Store", "readme.txt", "undistorted/images/._IMG_0001.jpg")
SKY, PERSON, BUILDING = (70, 130, 180), (220, 20, 60), (70, 70, 70)  # Cityscapes, RGB


def split_of(source: Path) -> dict[str, str]:
    """The split of every photo, by its file name."""
    (path,) = (source / "undistorted").glob("*_split.csv")
    return dict(line.split(";") for line in path.read_text().split()[1:])


def model_of(source: Path) -> pycolmap.Reconstruction:
    """The scene's COLMAP model."""
    return pycolmap.Reconstruction(str(source / "undistorted" / "sparse" / "0"))


def world_from_cam(image: pycolmap.Image) -> np.ndarray:
    """A camera's pose ``[4, 4]`` with OpenCV axes."""
    pose = np.eye(4)
    pose[:3] = image.cam_from_world().inverse().matrix()
    return pose


def as_published(source: Path, target: Path) -> list[str]:
    """The NeRF-OSR layout with all its quirks; returns the stems whose sky masks are left out."""
    shutil.copytree(source, target)
    folder = target / "undistorted"
    names = sorted(split_of(source))
    suffixes = (".JPG", ".jpg", ".jpeg", ".JPEG")
    for number, name in enumerate(names):
        stem = Path(name).stem
        photo = folder / "images" / name
        photo.rename(photo.with_suffix(suffixes[number % 4]))
        mask = folder / "masks" / f"{stem}.png"
        mask.rename(mask.with_suffix((".PNG", ".png")[number % 2]))
    (split,) = folder.glob("*_split.csv")
    lines = split.read_text().split()
    shouted = [line.replace(".jpg", ".JPG") for line in lines]
    split.write_text("\ufeff" + "\r\n".join(shouted))
    config = target / "eval_files" / "test_config.py"
    config.write_text(config.read_text().replace("eval_files/", "/home/author/place/eval_files/"))
    model = folder / "sparse" / "0"
    reconstruction = pycolmap.Reconstruction(str(model))
    for path in model.iterdir():
        path.unlink()
    reconstruction.write_text(str(model))
    for extra in EXTRA_FILES:
        (target / extra).write_bytes(b"not a picture")
    shutil.copy(folder / "images" / Path(names[0]).with_suffix(".JPG"), folder / "unlisted.jpg")
    dropped = [Path(name).stem for name in names[::2]]
    for stem in dropped:
        (folder / "sky_masks" / f"{stem}.png").unlink()
    return dropped


def colmap_folder(source: Path, target: Path) -> None:
    """images/, sparse/, masks named as COLMAP names them, and the split list."""
    shutil.copytree(source / "undistorted" / "images", target / "images")
    shutil.copytree(source / "undistorted" / "sparse" / "0", target / "sparse")
    shutil.copytree(source / "undistorted" / "sky_masks", target / "sky_masks")
    shutil.copytree(source / "eval_files", target / "eval_files")
    (target / "masks").mkdir()
    for name in split_of(source):
        mask = source / "undistorted" / "masks" / f"{Path(name).stem}.png"
        shutil.copy(mask, target / "masks" / f"{name}.png")
    (split,) = (source / "undistorted").glob("*_split.csv")
    shutil.copy(split, target)


def nerfstudio(source: Path, target: Path) -> None:
    """transforms.json in a world with z up, its photos, masks and sparse_pc.ply."""
    for name in ("images", "masks", "sky_masks"):
        shutil.copytree(source / "undistorted" / name, target / name)
    shutil.copytree(source / "eval_files", target / "eval_files")
    model = model_of(source)
    frames = []
    for image in model.images.values():
        pose = world_from_cam(image)
        x, y, z, w = pose
        turned = np.stack([x, z, -y, w])  # z up
        fx, fy, cx, cy = image.camera.params
        mask = f"masks/{Path(image.name).stem}.png"
        frame = {"file_path": f"images/{image.name}", "mask_path": mask}
        frame |= {"fl_x": fx, "fl_y": fy, "cx": cx, "cy": cy}
        frame |= {"w": image.camera.width, "h": image.camera.height}
        # OpenGL cameras: the second and third axis point the other way.
        frame["transform_matrix"] = (turned * [1, -1, -1, 1]).tolist()
        frames.append(frame)
    splits = split_of(source)
    content = {"camera_model": "OPENCV", "frames": frames, "ply_file_path": "sparse_pc.ply"}
    for which in ("train", "test"):
        names = [f"images/{name}" for name, split in splits.items() if split == which]
        content[f"{which}_filenames"] = names
    (target / "transforms.json").write_text(json.dumps(content))
    _write_ply(model, target / "sparse_pc.ply")


def _write_ply(model: pycolmap.Reconstruction, path: Path) -> None:
    properties = [f"property float {axis}" for axis in "xyz"]
    properties += [f"property uint8 {colour}" for colour in ("red", "green", "blue")]
    points = [model.points3D[identifier] for identifier in sorted(model.points3D)]
    rows = [
        f"{p.xyz[0]:.9g} {p.xyz[2]:.9g} {-p.xyz[1]:.9g} {p.color[0]} {p.color[1]} {p.color[2]}"
        for p in points
    ]
    header = ["ply", "format ascii 1.0", f"element vertex {len(rows)}", *properties, "end_header"]
    path.write_text("\n".join(header + rows) + "\n")


def nerf_osr_original(source: Path, target: Path) -> None:
    """final/{train,test}/{rgb,pose,intrinsics,mask,cityscapes_mask}, and eval_files/."""
    shutil.copytree(source / "eval_files", target / "eval_files")
    splits = split_of(source)
    for image in model_of(source).images.values():
        folder, stem = target / "final" / splits[image.name], Path(image.name).stem
        intrinsics = np.eye(4)
        intrinsics[:3, :3] = image.camera.calibration_matrix()
        for kind in ("rgb", "pose", "intrinsics", "mask", "cityscapes_mask"):
            (folder / kind).mkdir(parents=True, exist_ok=True)
        shutil.copy(source / "undistorted" / "images" / image.name, folder / "rgb")
        shutil.copy(source / "undistorted" / "masks" / f"{stem}.png", folder / "mask")
        for kind, matrix in (("pose", world_from_cam(image)), ("intrinsics", intrinsics)):
            text = " ".join(repr(float(value)) for value in matrix.ravel())
            (folder / kind / f"{stem}.txt").write_text(text + "\n")
        labels = labels_of(source, stem)
        cv2.imwrite(str(folder / "cityscapes_mask" / f"{stem}.png"), labels[..., ::-1])


def labels_of(source: Path, stem: str) -> np.ndarray:
    """Cityscapes colours, RGB, from a scene's masks."""
    read = [
        cv2.imread(str(source / "undistorted" / name / f"{stem}.png"), cv2.IMREAD_GRAYSCALE) >= 128
        for name in ("masks", "sky_masks")
    ]
    labels = np.full((*read[0].shape, 3), BUILDING, np.uint8)
    labels[~read[1]] = SKY
    labels[~read[0]] = PERSON
    return labels
