# Tables and figures over all runs.


rule table1:
    input:
        code=library("reporting"),
        published=PUBLISHED,
        metrics=collect(
            "results/{scene}/{variant}/seed{seed}/metrics/metrics.json",
            scene=SCENES,
            variant=CONFIG.variants,
            seed=CONFIG.seeds,
        ),
    output:
        csv=ensure("results/table1.csv", non_empty=True),
        markdown="results/table1.md",
        latex="results/table1.tex",
        decomposition="results/decomposition.csv",
        runs="results/runs.csv",
    log:
        "logs/table1.log",
    shell:
        "python -m r3gw tables --kind table1 --published {input.published}"
        " --target results {input.metrics} > {log} 2>&1"


rule ablation_table:
    input:
        code=library("reporting"),
        metrics=collect(
            "results/{scene}/{variant}/seed{seed}/metrics/metrics.json",
            scene=SCENES,
            variant=CONFIG.ablations.variants,
            seed=CONFIG.ablations.seeds,
        ),
    output:
        csv=ensure("results/ablations.csv", non_empty=True),
        runs="results/ablation_runs.csv",
    log:
        "logs/ablations.log",
    shell:
        "python -m r3gw tables --kind ablations --target results {input.metrics} > {log} 2>&1"


rule figures:
    input:
        code=library("reporting"),
        scene="results/{scene}/scene/scene.json",
        metrics=figure_metrics,
    output:
        multiext(
            "results/figures/{scene}_",
            "views.png",
            "decomposition.png",
            "lights.png",
            "training.png",
        ),
    log:
        "logs/figures/{scene}.log",
    params:
        runs=figure_runs,
    shell:
        "python -m r3gw figures --name {wildcards.scene}"
        " --scene results/{wildcards.scene}/scene --target results/figures"
        " {params.runs} > {log} 2>&1"
