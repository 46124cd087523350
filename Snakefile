# r3gw: photos or a dataset -> SfM import -> masks -> sky initialisation -> training ->
# evaluation -> tables, figures, report. `snakemake --cores 2 all` makes results/table1.csv;
# `snakemake --cores 2 ablations` makes results/ablations.csv; with
# `--configfile config/studies/short_runs.yaml`, `study` makes results/study.csv.
import os

from snakemake.utils import min_version

min_version("9.0")


# A file given with --configfile that names scenes stands alone.
if "scenes" not in config:

    configfile: "config/config.yaml"


report: "workflow/report/workflow.rst"


# With `--software-deployment-method apptainer` every stage runs in this image (docs/cluster.md).
CONTAINER = os.environ.get("R3GW_CONTAINER")


container: CONTAINER


include: "workflow/rules/common.smk"
include: "workflow/rules/doctor.smk"
include: "workflow/rules/scenes.smk"
include: "workflow/rules/train.smk"
include: "workflow/rules/evaluate.smk"
include: "workflow/rules/report.smk"


rule all:
    default_target: True
    input:
        "results/doctor/doctor.json",
        "results/table1.csv",
        "results/cost.csv",
        "results/report.html",
        collect(
            "results/figures/{scene}_{kind}.png", scene=SCENES, kind=["masks", "views"]
        ),


rule ablations:
    input:
        "results/ablations.csv",


rule study:
    input:
        "results/study.csv",
