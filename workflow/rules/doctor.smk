# The doctor: what would fail later is said before hours of CPU go into it. Before the first job, all
# sources are looked at in one go, so that a mistake in one scene starts no other. This is no rule: an
# edge from one scene to another would make the other stale, and `ancient()` would hide what really is
# stale (Snakemake 9 does not ask jobs below a job that runs whether they have a reason of their own).
# The gates of a scene and of a run become stale only together with what they guard, so a new check
# makes nothing again; they take no code as input for the same reason. The page is a leaf. High
# priorities let all of them run as early as they can.


onstart:
    refuse_broken_sources()


rule doctor_source:
    output:
        "results/{scene}/checked_source.json",
    log:
        "logs/doctor_source/{scene}.log",
    priority: 100
    params:
        entries=entry_by_name_json,
    shell:
        "python -m r3gw doctor-sources --entries {params.entries:q}"
        " --target {output} 2>&1 | tee {log} >&2"


rule doctor_scene:
    input:
        scene="results/{scene}/scene/scene.json",
        masks="results/{scene}/masks/masks.json",
        initial="results/{scene}/initial.npz",
    output:
        "results/{scene}/checked.json",
    log:
        "logs/doctor_scene/{scene}.log",
    priority: 100
    shell:
        "python -m r3gw doctor-scene --scene {wildcards.scene} --results results"
        " --target {output} 2>&1 | tee {log} >&2"


rule doctor_run:
    input:
        checked="results/{scene}/checked.json",
        settings="results/{scene}/{variant}/seed{seed}/settings.json",
    output:
        "results/{scene}/{variant}/seed{seed}/checked.json",
    log:
        "logs/doctor_run/{scene}.{variant}.seed{seed}.log",
    priority: 100
    shell:
        "python -m r3gw doctor-run"
        " --name {wildcards.scene}/{wildcards.variant}/seed{wildcards.seed}"
        " --checked {input.checked} --settings {input.settings}"
        " --target {output} 2>&1 | tee {log} >&2"


rule doctor:
    input:
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
        code=code_of("doctor"),
        config=config_json(),
        defaults=DEFAULTS,
    shell:
        "printf '%s\n' {params.config:q} > {output.config};"
        " python -m r3gw doctor --config {output.config} --defaults {params.defaults}"
        " --results results --target results/doctor 2>&1 >{log} | tee -a {log} >&2"


rule mask_sheet:
    input:
        scene="results/{scene}/scene/scene.json",
        masks="results/{scene}/masks/masks.json",
    output:
        "results/figures/{scene}_masks.png",
    log:
        "logs/mask_sheet/{scene}.log",
    params:
        code=code_of("mask-sheet"),
    shell:
        "python -m r3gw mask-sheet --name {wildcards.scene}"
        " --scene results/{wildcards.scene}/scene --masks results/{wildcards.scene}/masks"
        " --target results/figures > {log} 2>&1"
