"""The figures' entry: those of a scene, ``<scene>_<kind>.png``, and that of a study."""

from collections.abc import Sequence
from pathlib import Path

from r3gw.files import InputError
from r3gw.reporting.figures.comparisons import depth_figure, sky_boundary_figure, surfaces_figure
from r3gw.reporting.figures.grids import decomposition_grid, light_grid, view_grid
from r3gw.reporting.figures.mask_sheet import occluder_sheet
from r3gw.reporting.figures.plots import is_swept, study_plot, sweep_plot, training_plot
from r3gw.reporting.figures.points import initial_figure, sfm_figure
from r3gw.reporting.figures.relighting import learned_figure, shared_light_figure, turned_figure
from r3gw.reporting.figures.style import look, save
from r3gw.reporting.runs import load_run
from r3gw.reporting.tables.listings import runs_table
from r3gw.reporting.tables.study import study_table
from r3gw.scene import load_points, load_scene


def scene_figures(
    scene: str, scene_folder: Path, masks_folder: Path, run_folders: Sequence[Path], target: Path
) -> None:
    """Draw the figures of a scene.

    Args:
        scene: Name of the scene, the beginning of the files' names.
        scene_folder: Imported scene; initial.npz lies beside it.
        masks_folder: Its masks.
        run_folders: One folder per variant, with history.csv and metrics/; the first one (the
            full method) is shown in the figures that show one run.
        target: Folder of figures. Gets ``<scene>_<kind>.png`` for `PICTURES` and `PLOTS`, the
            latter also as .pdf (`.kinds`), a plot ``sweep`` where views were swept, and a picture
            ``occluders`` where the first run looked for some.

    Raises:
        InputError: If a file is missing or there is no run.
    """
    if not run_folders:
        raise InputError(f"figures of scene {scene} need at least one run; evaluate one first")
    imported, points = load_scene(scene_folder), load_points(scene_folder)
    runs = [load_run(folder / "metrics" / "metrics.json") for folder in run_folders]
    main = runs[0]
    with look():
        pictures = {
            "views": view_grid(imported, scene_folder, runs),
            "depth": depth_figure(imported, scene_folder, runs),
            "sky_boundary": sky_boundary_figure(imported, scene_folder, masks_folder, runs),
            "surfaces": surfaces_figure(imported, scene_folder, main),
            "decomposition": decomposition_grid(imported, scene_folder, main),
            "lights": light_grid(imported, scene_folder, main),
            "relit_map": turned_figure(main),
            "relit_learned": learned_figure(main),
            "shared_light": shared_light_figure(main),
        }
        plots = {
            "training": training_plot(runs),
            "initial": initial_figure(imported, points, scene_folder.with_name("initial.npz")),
            "sfm": sfm_figure(imported, points),
        }
        found = occluder_sheet(scene_folder, masks_folder, run_folders[0])
        if found is not None:
            pictures["occluders"] = found
        if is_swept(main):
            plots["sweep"] = sweep_plot(main)
        for kind, figure in pictures.items():
            save(figure, target / f"{scene}_{kind}.png", as_pdf=False)
        for kind, figure in plots.items():
            save(figure, target / f"{scene}_{kind}.png", as_pdf=True)


def write_study(
    metrics_files: Sequence[Path], baseline: str, table: Path, runs: Path, figure: Path
) -> None:
    """Compare variants with a baseline, as tables and as a plot of PSNR over training seconds.

    Args:
        metrics_files: metrics.json of every run, each in its run's folder.
        baseline: The variant that all others are compared with.
        table: The comparison (.csv); .md comes beside it.
        runs: Table with one row per run (.csv).
        figure: The plot (.png, and as .pdf).

    Raises:
        InputError: If a file is missing or malformed, or no run is of the baseline.
    """
    runs_table(metrics_files, runs)
    compared = study_table(metrics_files, baseline, table)
    with look():
        save(study_plot(compared, baseline), figure, as_pdf=True)
