"""Rendering a scene session by session, in one process or several."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from math import pi
from multiprocessing import get_context
from pathlib import Path

from r3gw.benchmark import lights, render, write
from r3gw.benchmark.buildings import chapel, colonnade, townhouse
from r3gw.benchmark.lights import Session
from r3gw.benchmark.place import Place
from r3gw.benchmark.seeds import stream
from r3gw.benchmark.shooting import Exposure, Plan, Studio
from r3gw.files.processes import end_with_parent

PLACES = {module.PLACE.name: module.PLACE for module in (chapel, colonnade, townhouse)}


@dataclass(frozen=True)
class Work:
    """One scene's rendering, as a process of its own needs to know it.

    Attributes:
        place: Name of the place.
        seed: Seed of all random streams.
        samples: Light paths per pixel.
        is_denoised: Whether photos are smoothed.
        root: Folder that files are written to.
    """

    place: str
    seed: int
    samples: int
    is_denoised: bool
    root: Path

    def visit(
        self, session: Session, plans: Sequence[Plan]
    ) -> tuple[list[write.Taken], write.Panorama]:
        """Render and write the photos of one session, and its light."""
        render.use_one_thread()
        studio = _studio(self)
        random = stream(self.seed, self.place, session.name)
        light = lights.environment(session, random)
        yaw_rad = lights.whole_pixel_yaw(float(random.uniform(-pi, pi)))
        write.write_light(self.root, session, light, yaw_rad)
        exposure = Exposure(light, random)
        emitter = render.emitter(light)
        place = studio.lit(emitter)
        taken = [
            write.write_shot(self.root, studio.shoot(plan, place, emitter, exposure))
            for plan in plans
        ]
        return taken, write.Panorama(yaw_rad, lights.clipped_scale(light))


@lru_cache(maxsize=1)
def _studio(work: Work) -> Studio:
    """A process builds a place once, for all sessions that it renders."""
    place = PLACES[work.place]
    return Studio(place, work.seed, work.samples, is_denoised=work.is_denoised)


def render_visits(
    scene: Place,
    plans: Sequence[Plan],
    work: Work,
    num_processes: int,
    done: Callable[[int], object],
) -> tuple[list[write.Taken], dict[str, write.Panorama]]:
    """Render and write session by session; return photos by name, and the panoramas."""
    visits = [
        (session, [plan for plan in plans if plan.session == session]) for session in scene.sessions
    ]
    visits = [(session, visit) for session, visit in visits if visit]
    shots, panoramas = [], {}
    with _workers(num_processes) as pool:
        run = map if pool is None else pool.map
        for (session, _), (taken, panorama) in zip(
            visits, run(work.visit, *zip(*visits, strict=True)), strict=True
        ):
            shots += taken
            panoramas[session.name] = panorama
            done(len(taken))
    return sorted(shots, key=lambda shot: shot.stem), panoramas


@contextmanager
def _workers(count: int) -> Iterator[ProcessPoolExecutor | None]:
    """Processes of their own for Mitsuba; None where one is enough."""
    if count == 1:
        yield None
        return
    with ProcessPoolExecutor(
        count, mp_context=get_context("spawn"), initializer=end_with_parent
    ) as pool:
        yield pool
