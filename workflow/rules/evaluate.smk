# Scores and pictures of one run.


rule evaluate:
    input:
        scene="results/{scene}/scene/scene.json",
        masks="results/{scene}/masks/masks.json",
        model="results/{scene}/{variant}/seed{seed}/model.safetensors",
        record="results/{scene}/{variant}/seed{seed}/run.json",
        timing="results/{scene}/{variant}/seed{seed}/timing.json",
        checked="results/{scene}/checked.json",  # for `mem_mb`
    output:
        metrics="results/{scene}/{variant}/seed{seed}/metrics/metrics.json",
        lights="results/{scene}/{variant}/seed{seed}/metrics/lights.json",
        relit="results/{scene}/{variant}/seed{seed}/metrics/relit/relit.json",
        cost="results/{scene}/{variant}/seed{seed}/metrics/cost.json",
    log:
        "logs/evaluate/{scene}.{variant}.seed{seed}.log",
    threads: 1
    resources:
        mem_mb=memory_mb,
    params:
        code=code_of("evaluate"),
    shell:
        "python -m r3gw evaluate --scene results/{wildcards.scene}/scene"
        " --masks results/{wildcards.scene}/masks --model {input.model}"
        " --threads {threads}"
        " --target results/{wildcards.scene}/{wildcards.variant}/seed{wildcards.seed}/metrics"
        " > {log} 2>&1"
