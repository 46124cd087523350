# The doctor: what would fail later is said before hours of CPU go into it. The two gates become
# stale only together with what they guard, so a new check makes nothing again; they take no code as
# input for the same reason. The page is a leaf. High priorities let all of them run early.


rule check_source:
    output:
        "results/{scene}/checked_source.json",
    log:
        "logs/check_source/{scene}.log",
    priority: 100
    params:
        entry=entry_json,
    shell:
        "python -m r3gw check-source --scene {wildcards.scene} --entry {params.entry:q}"
        " --target {output} 2>&1 | tee {log} >&2"


rule check_scene:
    input:
        scene="results/{scene}/scene/scene.json",
        masks="results/{scene}/masks/masks.json",
        initial="results/{scene}/initial.npz",
    output:
        "results/{scene}/checked.json",
    log:
        "logs/check_scene/{scene}.log",
    priority: 100
    shell:
        "python -m r3gw check-scene --scene {wildcards.scene} --results results"
        " --target {output} 2>&1 | tee {log} >&2"


rule doctor:
    input:
        code=library("doctor"),
        settings=[TRAIN_FILE, VARIANTS_FILE],
        scenes=collect(
            "results/{scene}/{file}",
            scene=SCENES,
            file=["scene/scene.json", "masks/masks.json", "initial.npz"],
        ),
    output:
        config="results/doctor/config.json",
        record="results/doctor/doctor.json",
    log:
        "logs/doctor.log",
    priority: 100
    params:
        config=config_json(),
        defaults=DEFAULTS,
    shell:
        "printf '%s\n' {params.config:q} > {output.config};"
        " python -m r3gw doctor --config {output.config} --defaults {params.defaults}"
        " --results results --target results/doctor 2>&1 >{log} | tee -a {log} >&2"


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
