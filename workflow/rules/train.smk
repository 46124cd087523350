# One training: a scene, a variant, a seed.


# A line of the shell: on a cluster not worth a job.
localrules:
    write_settings,


# Settings reach a run as `params` and leave as a file: an edit to one variant re-runs that
# variant alone, and every result keeps the settings that made it.
rule write_settings:
    output:
        "results/{scene}/{variant}/seed{seed}/settings.json",
    log:
        "logs/write_settings/{scene}.{variant}.seed{seed}.log",
    priority: 50
    params:
        settings=settings_json,
    shell:
        "printf '%s\n' {params.settings:q} > {output} 2> {log}"


# The doctor refuses a training that this machine cannot hold. Snakemake does not see imports: without
# `code`, an edit to src/r3gw leaves a stale model.
rule train:
    input:
        scene="results/{scene}/scene/scene.json",
        masks="results/{scene}/masks/masks.json",
        initial="results/{scene}/initial.npz",
        settings="results/{scene}/{variant}/seed{seed}/settings.json",
        checked="results/{scene}/checked.json",
    output:
        model=ensure(
            "results/{scene}/{variant}/seed{seed}/model.safetensors", non_empty=True
        ),
        history="results/{scene}/{variant}/seed{seed}/history.csv",
        record="results/{scene}/{variant}/seed{seed}/run.json",
        timing="results/{scene}/{variant}/seed{seed}/timing.json",
    log:
        "logs/train/{scene}.{variant}.seed{seed}.log",
    benchmark:
        "logs/train/{scene}.{variant}.seed{seed}.tsv"
    threads: 1
    resources:
        mem_mb=memory_mb,
        runtime=runtime_min,
    params:
        code=code_of("train"),
    shell:
        "python -m r3gw doctor-run"
        " --name {wildcards.scene}/{wildcards.variant}/seed{wildcards.seed}"
        " --checked {input.checked} --settings {input.settings} 2>&1 | tee {log} >&2;"
        " python -m r3gw train --scene results/{wildcards.scene}/scene"
        " --masks results/{wildcards.scene}/masks --initial {input.initial}"
        " --settings {input.settings} --name {wildcards.scene}"
        " --variant {wildcards.variant} --threads {threads}"
        " --target results/{wildcards.scene}/{wildcards.variant}/seed{wildcards.seed}"
        " >> {log} 2>&1"
