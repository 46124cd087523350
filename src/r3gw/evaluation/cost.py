"""What showing a scene costs, measured: renders per second and peak memory."""

from time import perf_counter

from r3gw.evaluation.evaluated_scene import EvaluatedScene
from r3gw.files.provenance import peak_rss_mb
from r3gw.model.lights import photo_light

NUM_WARM_UP = 3
NUM_TIMED = 30


def measured_cost(evaluated: EvaluatedScene, num_threads: int) -> dict[str, float | int]:
    """Time renders of the training views under their learned lights and skies.

    Returns:
        ``renders_per_second`` (views taken in turn, shading and sky included, lights at hand),
        the mean ``render_megapixels`` of one, ``render_threads``, and ``peak_rss_mb`` of the
        process so far.
    """
    views = evaluated.scene.split("train")
    lights = [photo_light(evaluated.model, view.name) for view in views]
    turns = [i % len(views) for i in range(NUM_WARM_UP + NUM_TIMED)]
    start = perf_counter()
    for number, i in enumerate(turns):
        if number == NUM_WARM_UP:
            start = perf_counter()
        evaluated.render(views[i], lights[i])
    seconds = perf_counter() - start
    return {
        "renders_per_second": NUM_TIMED / seconds,
        "render_megapixels": sum(view.width * view.height for view in views) / len(views) / 1e6,
        "render_threads": num_threads,
        "peak_rss_mb": peak_rss_mb(),
    }
