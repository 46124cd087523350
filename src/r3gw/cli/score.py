"""Scoring pictures of any origin."""

from dataclasses import asdict
from pathlib import Path

import click

from r3gw.cli.group import FILE, FOLDER, cli
from r3gw.cli.told import wrote


@cli.command(short_help="Score any method's pictures as ours are scored.")
@click.option(
    "--renders",
    type=FOLDER,
    required=True,
    help="Pictures to score (PNG, JPEG), or what 3DGS, gsplat, nerfstudio or LumiGauss wrote.",
)
@click.option(
    "--truth",
    type=FOLDER,
    help="Photos of the same names; needed unless the program wrote them beside its renders.",
)
@click.option("--masks", type=FOLDER, help="Masks of the same names, white = counts.")
@click.option("--output", type=FILE, help="CSV with one row per picture.")
def score(renders: Path, truth: Path | None, masks: Path | None, output: Path | None) -> None:
    """Score any method's pictures as this project scores its own.

    Renders that are only numbered go with photos and masks in the order of those names.

    Masks are resized to the picture, thresholded and eroded by 5x5. The figure to compare is
    "masked"; "zero-filled" and "pooled" are what some papers print instead.
    """
    import pandas as pd

    from r3gw.evaluation.scoring import mean_scores, pooled_scores, score_folders
    from r3gw.files import atomic_path

    scored = score_folders(renders, truth, masks)
    rows = {
        "masked (the protocol: mean over pictures)": mean_scores([each.masked for each in scored]),
        "zero-filled (not comparable: averages over the black outside)": mean_scores(
            [each.zero_filled for each in scored]
        ),
        "pooled (not comparable: all pixels of all pictures in one mean)": pooled_scores(scored),
    }
    table = pd.DataFrame([asdict(each.masked) for each in scored], [each.name for each in scored])
    click.echo(table.to_markdown(floatfmt=".4f") + "\n")
    summary = pd.DataFrame([asdict(each) for each in rows.values()], list(rows))
    click.echo(summary.to_markdown(floatfmt=".4f"))
    if output is not None:
        filled = pd.DataFrame([asdict(e.zero_filled) for e in scored], table.index)
        table = table.join(filled.add_suffix("_zero_filled"))
        table["num_pixels"] = [each.num_pixels for each in scored]
        with atomic_path(output) as path:
            table.to_csv(path, index_label="picture", float_format="%.6g")
        wrote(output)
