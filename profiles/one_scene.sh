#!/bin/bash
# Makes and scores the models of one scene in a working folder of its own, for clusters whose nodes
# share no working folder, or only a slow one (docs/cluster.md).
#
#   bash profiles/one_scene.sh HOME CONFIGFILE SCENE "VARIANT ..." "SEED ..." [SNAKEMAKE'S OPTIONS]
#
# What is finished, and every checkpoint, goes to HOME/results/SCENE once a minute and at the end.
# With R3GW_SCRATCH the work is done in that folder of the node's own disk, and begins with what HOME
# holds of the scene. Killed and started again, on any node, it goes on.
set -euo pipefail
home=$(realpath "$1") configfile=$(realpath "$2") scene=$3 variants=$4 seeds=$5
shift 5
checkout=$(realpath "$(dirname "$0")/..")
work=${R3GW_SCRATCH:-$home/parts}/$scene
mkdir -p "$work/results" "$home/results/$scene"
cd "$work"

carry() { # from, to: whole files only; a source that is still being rendered stays where it is
    local unfinished=(--exclude '..*')
    [ -f "$1/results/$scene/scene/scene.json" ] || unfinished+=(--exclude /source)
    rsync --archive "${unfinished[@]}" "$1/results/$scene/" "$2/results/$scene/"
}
mkdir -p "results/$scene"
carry "$home" "$work"
while sleep 60; do carry "$work" "$home"; done &
carrier=$!
trap 'kill $carrier; carry "$work" "$home"' EXIT

targets=()
for variant in $variants; do
    for seed in $seeds; do
        targets+=("results/$scene/$variant/seed$seed/metrics/metrics.json")
    done
done
snakemake --snakefile "$checkout/workflow/Snakefile" --configfile "$configfile" "$@" -- "${targets[@]}"
