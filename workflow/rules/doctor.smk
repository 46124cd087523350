# The doctor: what would fail later is said before hours of CPU go into it. Before the first job, all
# sources are looked at in one go, so that a mistake in one scene starts no other. The gate of a scene
# stands before its trainings; it takes no code as input, so that a new check makes nothing again. The
# page is a leaf. High priorities let both run as early as they can.


onstart:
    refuse_broken_sources()
    show_progress()


onsuccess:
    say_what_slurm_ended()


onerror:
    say_what_slurm_ended()


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


rule doctor:
    input:
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
        settings=[state_of(TRAIN_FILE), state_of(VARIANTS_FILE)],
    shell:
        "printf '%s\n' {params.config:q} > {output.config};"
        " python -m r3gw doctor --config {output.config} --defaults {params.defaults:q}"
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
