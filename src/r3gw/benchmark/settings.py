"""What a user may choose about a scene of the embedded benchmark."""

from pydantic import Field

from r3gw.files.strict import Strict


class BenchmarkSettings(Strict):
    """What is rendered: which building, how many photos of which size, how cleanly.

    Attributes:
        building: Name of a scene (`r3gw.benchmark.generate.SCENES`).
        seed: Drives textures, plants, clouds, cameras, exposures and passers-by.
        width_px, height_px: Nominal size of the photos.
        train_views, test_views: Photos of training and of test sessions.
        samples: Light paths per pixel.
        visits: Training sessions; null takes the place's own.
        devices: Devices with lenses that took the photos; 0 gives every photo its own pinhole.
        denoise: Whether photos are smoothed, for few samples.
        points: Sparse points to try.
    """

    building: str
    seed: int = Field(0, ge=0)
    width_px: int = Field(240, ge=16)
    height_px: int = Field(180, ge=16)
    train_views: int = Field(20, ge=2)
    test_views: int = Field(4, ge=1)
    samples: int = Field(20, ge=1)
    visits: int | None = Field(None, ge=1)
    devices: int = Field(0, ge=0, le=4)
    denoise: bool = False
    points: int = Field(9000, ge=100)
