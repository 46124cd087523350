# From a dataset, a folder of photos or the embedded benchmark to masks and initial points.


rule generate:
    output:
        directory("results/{scene}/source"),
    log:
        "logs/generate/{scene}.log",
    wildcard_constraints:
        scene="|".join(SYNTHETIC) or "none",
    priority: 10
    threads: GENERATE_THREADS
    params:
        code=code_of("generate"),
        settings=benchmark_json,
    shell:
        "python -m r3gw generate --settings {params.settings:q} --target {output}"
        " --processes {threads} > {log} 2>&1"


rule import_scene:
    input:
        rendered_source,
    output:
        "results/{scene}/scene/scene.json",
        "results/{scene}/scene/points.npz",
    log:
        "logs/import/{scene}.log",
    priority: 10
    threads: import_threads
    params:
        code=code_of("import"),
        entry=source_json,
        source=scene_source,
        given=given_state,
    shell:
        "python -m r3gw import --scene {wildcards.scene} --entry {params.entry:q}"
        " --source {params.source:q} --target results/{wildcards.scene}/scene"
        " --threads {threads} > {log} 2>&1"


rule masks:
    input:
        scene="results/{scene}/scene/scene.json",
        points="results/{scene}/scene/points.npz",
    output:
        "results/{scene}/masks/masks.json",
    log:
        "logs/masks/{scene}.log",
    priority: 10
    params:
        code=code_of("masks"),
        sources=mask_sources,
        given=mask_state,
    shell:
        "python -m r3gw masks --scene results/{wildcards.scene}/scene"
        " --sources {params.sources:q} --target results/{wildcards.scene}/masks > {log} 2>&1"


rule initialise:
    input:
        scene="results/{scene}/scene/scene.json",
        points="results/{scene}/scene/points.npz",
        masks=stereo_masks,
    output:
        "results/{scene}/initial.npz",
    log:
        "logs/initialise/{scene}.log",
    priority: 10
    params:
        code=code_of("initialise"),
        sky=sky_json,
        stereo=lambda wildcards, input: (
            f"--masks results/{wildcards.scene}/masks" if input.masks else ""
        ),
    shell:
        "python -m r3gw initialise --scene results/{wildcards.scene}/scene"
        " --sky {params.sky:q} {params.stereo} --target {output} > {log} 2>&1"
