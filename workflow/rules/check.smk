# The doctor: what would fail later is said before hours of CPU go into it. What it guards takes
# its records as ancient(): they must be there, but a newer one makes nothing again.


rule doctor_sources:
    input:
        code=library("doctor"),
        settings=[TRAIN_FILE, VARIANTS_FILE],
    output:
        config="results/doctor/config.json",
        record="results/doctor/sources.json",
    log:
        "logs/doctor/sources.log",
    params:
        config=config_json(),
        defaults=DEFAULTS,
    shell:
        "printf '%s\n' {params.config:q} > {output.config};"
        " python -m r3gw doctor --stage sources --config {output.config}"
        " --defaults {params.defaults} --target results/doctor"
        " > {log} 2> >(tee -a {log} >&2)"


rule doctor:
    input:
        code=library("doctor"),
        settings=[TRAIN_FILE, VARIANTS_FILE],
        config="results/doctor/config.json",
        scenes=collect(
            "results/{scene}/{file}",
            scene=SCENES,
            file=["scene/scene.json", "masks/masks.json", "initial.npz"],
        ),
    output:
        record="results/doctor/scenes.json",
    log:
        "logs/doctor/scenes.log",
    params:
        defaults=DEFAULTS,
    shell:
        "python -m r3gw doctor --stage scenes --config {input.config}"
        " --defaults {params.defaults} --target results/doctor"
        " > {log} 2> >(tee -a {log} >&2)"


rule mask_sheet:
    input:
        code=library("reporting"),
        scene="results/{scene}/scene/scene.json",
        masks="results/{scene}/masks/masks.json",
    output:
        "results/figures/{scene}_masks.png",
    log:
        "logs/mask_sheet/{scene}.log",
    shell:
        "python -m r3gw mask-sheet --name {wildcards.scene}"
        " --scene results/{wildcards.scene}/scene --masks results/{wildcards.scene}/masks"
        " --target results/figures > {log} 2>&1"
