# Every function and constant of the workflow; the other files hold rules only.
import json
import os
import re
import shlex
import sys
import time
from functools import cache, partial
from pathlib import Path
from subprocess import CalledProcessError

from r3gw.files import InputError
from r3gw.native.code import CODE, whole_digest
from r3gw.reporting.figures.kinds import PICTURES, PLOTS
from r3gw.reporting.methods import recommended
from r3gw.pipeline.code import StageCode
from r3gw.pipeline.config import load_config, run_settings
from r3gw.pipeline.doctor.training import predicted, read_size
from r3gw.pipeline.lock import claim
from r3gw.pipeline.progress import tell_progress
from r3gw.pipeline.slurm import failed_jobs
from r3gw.pipeline.source_state import source_state
from snakemake.exceptions import WorkflowError
from snakemake.settings.types import DeploymentMethod

try:
    CONFIG = load_config(config, "config")
except InputError as error:
    raise WorkflowError(str(error))

# The folder config/ that came with this workflow, wherever it is included from. A workflow that is
# used straight from its hosting site has it in the working folder, where snakedeploy puts it.
BESIDE = workflow.current_basedir.join("../../config").get_path_or_uri(secret_free=True)
DEFAULTS = os.path.normpath(BESIDE) if os.path.isdir(BESIDE) else "config"
TRAIN_FILE, VARIANTS_FILE = f"{DEFAULTS}/train.yaml", f"{DEFAULTS}/variants.yaml"
PUBLISHED = f"{DEFAULTS}/published.csv"
SCENES = sorted(CONFIG.scenes)
SYNTHETIC = [
    name for name in SCENES if CONFIG.scenes[name].source.format == "synthetic"
]
# Several scenes render side by side, one process each; a single one has all cores to itself.
# On a cluster it is one, unless --set-threads says more: a job's cores are not all of its node's.
CORES = (workflow.is_main_process and workflow.resource_settings.cores) or 1
GENERATE_THREADS = max(1, CORES // max(1, len(SYNTHETIC)))
VARIANTS, STUDY = CONFIG.all_variants, CONFIG.study
PAGE_VARIANT = recommended(CONFIG.variants)

GIVEN = sorted(set(SCENES) - set(SYNTHETIC))
if GIVEN and workflow.is_main_process:
    # Not again in each job of a cluster. Here, since it loads PyTorch and pycolmap, which the embedded scenes need not.
    from r3gw.importing.completeness import require_complete

    incomplete = []
    for name in GIVEN:
        try:
            entry = CONFIG.scenes[name]
            require_complete(
                name, entry.source, Path(entry.source.path), entry.given_masks
            )
        except InputError as error:
            incomplete.append(str(error))
    if incomplete:
        raise WorkflowError("\n".join(incomplete))

# Rules call the interpreter that runs Snakemake, whether its environment is active or not.
BIN = str(Path(sys.executable).parent)
for folder in (workflow.basedir, str(Path.cwd())):
    # Snakemake's own files beside the results are found by patterns, in which braces are wildcards.
    if set(folder) & set("{}"):
        raise WorkflowError(
            f"{folder}: Snakemake cannot run in a folder with a brace in its path; rename it"
        )
if ":" in BIN:
    raise WorkflowError(
        f"{BIN}: a folder with a colon in its name cannot be on the PATH; move the environment"
    )
# Twice quoted: for the shell, and for Snakemake, which takes braces for a format.
QUOTED_BIN = shlex.quote(BIN).replace("{", "{{").replace("}", "}}")
# Whoever is killed cannot say why, but the shell around it can.
KILLED = (
    "the command above was killed (SIGKILL). Unless somebody did that, it needed more memory"
    " than there was"
)
INTERPRETER = f"export PATH={QUOTED_BIN}:$PATH"
if DeploymentMethod.APPTAINER in workflow.deployment_settings.deployment_method:
    # In the container its own, if its code is that of this checkout; elsewhere as ever.
    INTERPRETER = (
        'if [ -n "${{APPTAINER_CONTAINER:-}}${{SINGULARITY_CONTAINER:-}}" ]; then unset PYTHONPATH;'
        f" export {CODE}={whole_digest()}; else {INTERPRETER}; fi"
    )
shell.prefix(
    f"set -euo pipefail; trap '[ $? != 137 ] || echo \"r3gw: {KILLED}\" >&2' EXIT;"
    f" {INTERPRETER}; "
)
# A lock that a killed run left is taken away, and stages end with the run that started them.
if workflow.is_main_process:
    os.environ.update(claim(Path.cwd()))
# By the environment, because no result depends on it: another interval makes nothing again.
os.environ.setdefault("R3GW_CHECKPOINT_SECONDS", str(CONFIG.checkpoint_seconds))


wildcard_constraints:
    scene="|".join(map(re.escape, SCENES)),
    variant="|".join(map(re.escape, VARIANTS)),
    seed=r"\d+",


STAGES = StageCode()


@cache
def code_of(command):
    """Digest of the code that a stage can reach, which is a parameter of its rule.

    An edit makes again what it concerns, as a changed input would, but Snakemake does not look at
    two hundred files again for every job of the graph. An extension that is older than its sources
    stops the workflow: its results would be recorded as those of the new code.
    """
    try:
        return STAGES.digest(command)
    except InputError as error:
        raise WorkflowError(str(error))


def config_json():
    """All of this run's configuration that results depend on, as JSON."""
    return CONFIG.model_dump_json(exclude={"checkpoint_seconds"})


def benchmark_json(wildcards):
    """What is rendered of an embedded scene, as JSON."""
    return CONFIG.scenes[wildcards.scene].source.benchmark().model_dump_json()


def import_threads(wildcards):
    """Two where features of photos may be matched; one where cameras and points are known.

    A job that wants all cores waits until every other has ended: the embedded scenes' imports, of
    three seconds, kept a core idle for a minute.
    """
    return 1 if wildcards.scene in SYNTHETIC else 2


def source_json(wildcards):
    """The half of a scene's config entry that is about its source, as JSON."""
    return CONFIG.scenes[wildcards.scene].source.model_dump_json()


def entries_json(names):
    """The config entries of scenes by name, as JSON."""
    return json.dumps(
        {name: CONFIG.scenes[name].model_dump(mode="json") for name in names}
    )


def refuse_broken_sources():
    """Stop before the first job, `keep-going` or not, if any scene's source would fail."""
    try:
        shell(
            "python -m r3gw doctor-sources --entries {entries:q}",
            entries=entries_json(SCENES),
        )
    except CalledProcessError:
        raise WorkflowError(
            "The doctor refuses the sources named above; no job was started."
        )


def show_progress():
    """Say now and then how far the running stages are, unless --quiet asks for less."""
    if not workflow.output_settings.quiet:
        say = partial(print, file=sys.stderr, flush=True)
        tell_progress(Path.cwd() / "logs", say)


STARTED_S = time.time()


def say_what_slurm_ended():
    """Say why jobs of this run failed on a cluster, those too that another attempt made good."""
    for sentence in failed_jobs(Path.cwd(), STARTED_S):
        print(f"r3gw: {sentence}", file=sys.stderr)


# Folders of the user's are parameters, not inputs: Snakemake would look for wildcards in their names,
# and sees the time of a folder, not of what is in it.
OWN_FOLDERS = [Path(name) for name in ("results", "logs", ".snakemake")]


@cache
def state_of(path):
    """State of a file or folder of the user's, by names, sizes and times of what is in it."""
    return source_state(Path(path), OWN_FOLDERS)


def scene_source(wildcards):
    """Folder (or video) that a scene is imported from."""
    source = CONFIG.scenes[wildcards.scene].source
    if source.format == "synthetic":
        return f"results/{wildcards.scene}/source"
    return source.path


def rendered_source(wildcards):
    """The source of an embedded scene, which a rule makes; users' own scenes have none."""
    return [scene_source(wildcards)] if wildcards.scene in SYNTHETIC else []


def given_state(wildcards):
    """State of a user's own source."""
    return "" if wildcards.scene in SYNTHETIC else state_of(scene_source(wildcards))


def mask_state(wildcards):
    """State of the label maps and of the network that a scene's masks are made with."""
    masks = CONFIG.scenes[wildcards.scene].masks
    named = [masks.label_maps, masks.network and masks.network.model]
    return [state_of(path) for path in named if path]


def mask_sources(wildcards):
    """The half of a scene's config entry that is about its masks, as JSON."""
    return CONFIG.scenes[wildcards.scene].masks.model_dump_json()


def resolved(variant, seed):
    """Settings of one run; a mistake in them stops the workflow with one sentence."""
    try:
        return run_settings(
            CONFIG,
            variant,
            seed,
            train_file=Path(TRAIN_FILE),
            variants_file=Path(VARIANTS_FILE),
        )
    except InputError as error:
        raise WorkflowError(str(error))


RESOLVED = {
    (variant, seed): resolved(variant, seed)
    for variant in VARIANTS
    for seed in CONFIG.all_seeds
}


def settings_json(wildcards):
    """Resolved settings of one run, as JSON: config/train.yaml with all changes on top."""
    settings = RESOLVED[wildcards.variant, int(wildcards.seed)]
    return settings.model_dump_json(indent=2)


def cost_of(wildcards):
    """What the doctor predicts of one training; unknown until its scene is imported."""
    checked = Path(f"results/{wildcards.scene}/checked.json")
    checked.stat()
    size = read_size(checked)
    return predicted(RESOLVED[wildcards.variant, int(wildcards.seed)], size)


def memory_mb(wildcards, attempt):
    """Memory of one run's training or evaluation in MB (10^6 bytes), more at another attempt."""
    return round(SNAKEMAKE_MB + cost_of(wildcards).memory_mb * (1 + MARGIN * attempt))


def runtime_min(wildcards, attempt):
    """Minutes after which a cluster may end a training."""
    return 5 + round(attempt * SLOWEST * cost_of(wildcards).seconds / 60)


def sky_json(wildcards):
    """Settings of the sky's initial points, as JSON."""
    return RESOLVED[VARIANTS[0], CONFIG.seeds[0]].sky.model_dump_json()


def stereo_masks(wildcards):
    """Masks that the first points depend on: none unless stereo adds to them."""
    if not RESOLVED[VARIANTS[0], CONFIG.seeds[0]].stereo.enabled:
        return []
    return f"results/{wildcards.scene}/masks/masks.json"


def figure_runs(wildcards):
    """Folders of the runs that a scene's figures show: every variant, first seed."""
    seed = CONFIG.seeds[0]
    return [
        f"results/{wildcards.scene}/{variant}/seed{seed}" for variant in CONFIG.variants
    ]


def figure_metrics(wildcards):
    """What the evaluation of those runs wrote."""
    return [f"{run}/metrics/metrics.json" for run in figure_runs(wildcards)]


def what_to_open():
    """Three lines for the end of a run: what was made, and what to look at first."""
    if not Path("results/report.html").is_file():
        return []
    pages = ", ".join(f"results/pages/{scene}.html" for scene in SCENES[:3])
    return [
        "Open results/report.html: all scenes, pictures, tables and costs on one page.",
        f"Relight a scene in your browser: {pages}{', ...' if len(SCENES) > 3 else ''}.",
        "The figures are in results/table1.csv (what they mean: docs/results.md).",
    ]


def study_metrics(wildcards):
    """What the evaluation of all runs of the study wrote, the baseline's first."""
    if STUDY is None:
        raise WorkflowError(
            "this configuration has no key 'study' (config/README.md); "
            "the project's own: --configfile config/studies/short_runs.yaml"
        )
    return collect(
        "results/{scene}/{variant}/seed{seed}/metrics/metrics.json",
        scene=SCENES,
        variant=STUDY.variants,
        seed=STUDY.seeds,
    )


def scene_figure(kind):
    """A figure of a scene, shown by `snakemake --report` too."""
    return report(
        f"results/figures/{{scene}}_{kind}.png",
        caption="../report/figures.rst",
        category="Scenes",
        subcategory="{scene}",
        labels={"figure": kind.replace("_", " ")},
    )


# A prediction is right within a factor of 1.3; machines differ in speed by more.
MARGIN, SLOWEST = 0.3, 4.0
# On a cluster a job is two processes of Snakemake's, too.
SNAKEMAKE_MB = 300

SCENE_FIGURES = [scene_figure(kind) for kind in (*PICTURES, *PLOTS)]
