# Tables, figures and the report over all runs.


rule table1:
    input:
        metrics=collect(
            "results/{scene}/{variant}/seed{seed}/metrics/metrics.json",
            scene=SCENES,
            variant=CONFIG.variants,
            seed=CONFIG.seeds,
        ),
    output:
        csv=report(
            ensure("results/table1.csv", non_empty=True),
            caption="../report/table1.rst",
            category="Tables",
        ),
        markdown="results/table1.md",
        latex="results/table1.tex",
        decomposition=report(
            "results/decomposition.csv",
            caption="../report/decomposition.rst",
            category="Tables",
        ),
        cost=report("results/cost.csv", caption="../report/cost.rst", category="Tables"),
        runs="results/runs.csv",
        images="results/images.csv",
    log:
        "logs/table1.log",
    params:
        code=code_of("tables"),
        published=PUBLISHED,
        figures=state_of(PUBLISHED),
    shell:
        "python -m r3gw tables --kind table1 --published {params.published:q}"
        " --target results {input.metrics} > {log} 2>&1"


rule ablation_table:
    input:
        metrics=collect(
            "results/{scene}/{variant}/seed{seed}/metrics/metrics.json",
            scene=SCENES,
            variant=CONFIG.ablations.variants,
            seed=CONFIG.ablations.seeds,
        ),
    output:
        csv=report(
            ensure("results/ablations.csv", non_empty=True),
            caption="../report/ablations.rst",
            category="Tables",
        ),
        runs="results/ablation_runs.csv",
    log:
        "logs/ablations.log",
    params:
        code=code_of("tables"),
    shell:
        "python -m r3gw tables --kind ablations --target results {input.metrics} > {log} 2>&1"


rule study_table:
    input:
        metrics=study_metrics,
    output:
        csv=report(
            ensure("results/study.csv", non_empty=True),
            caption="../report/study.rst",
            category="Tables",
        ),
        markdown="results/study.md",
        runs="results/study_runs.csv",
        figure=report(
            "results/figures/study.png",
            caption="../report/study.rst",
            category="Tables",
        ),
    log:
        "logs/study.log",
    params:
        code=code_of("study"),
        baseline=STUDY.baseline if STUDY else "",
    shell:
        "python -m r3gw study --baseline {params.baseline} --target {output.csv}"
        " --runs {output.runs} --figure {output.figure} {input.metrics} > {log} 2>&1"


rule figures:
    input:
        scene="results/{scene}/scene/scene.json",
        masks="results/{scene}/masks/masks.json",
        initial="results/{scene}/initial.npz",
        metrics=figure_metrics,
    output:
        SCENE_FIGURES,
    log:
        "logs/figures/{scene}.log",
    params:
        code=code_of("figures"),
        runs=figure_runs,
    shell:
        "python -m r3gw figures --name {wildcards.scene}"
        " --scene results/{wildcards.scene}/scene"
        " --masks results/{wildcards.scene}/masks --target results/figures"
        " {params.runs} > {log} 2>&1"


rule page:
    input:
        scene="results/{scene}/scene/scene.json",
        model=f"results/{{scene}}/{PAGE_VARIANT}/seed{CONFIG.seeds[0]}/model.safetensors",
    output:
        ensure("results/pages/{scene}.html", non_empty=True),
    log:
        "logs/pages/{scene}.log",
    params:
        code=code_of("page"),
    shell:
        "python -m r3gw page {input.model} --scene results/{wildcards.scene}/scene"
        " --target {output} > {log} 2>&1"


rule html_report:
    input:
        pages=collect("results/pages/{scene}.html", scene=SCENES),
        tables=["results/table1.csv", "results/decomposition.csv", "results/cost.csv"],
        initial=collect("results/{scene}/initial.npz", scene=SCENES),
        masks=collect("results/{scene}/masks/masks.json", scene=SCENES),
        metrics=collect(
            "results/{scene}/{variant}/seed{seed}/metrics/metrics.json",
            scene=SCENES,
            variant=CONFIG.variants,
            seed=CONFIG.seeds[0],
        ),
    output:
        ensure("results/report.html", non_empty=True),
    log:
        "logs/report.log",
    params:
        code=code_of("report"),
        scenes=collect("--scene {scene}", scene=SCENES),
        variants=collect("--variant {variant}", variant=CONFIG.variants),
        seed=CONFIG.seeds[0],
    shell:
        "python -m r3gw report --results results {params.scenes} {params.variants}"
        " --seed {params.seed} --pages pages --target {output} > {log} 2>&1"
