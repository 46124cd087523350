"""The help of ``r3gw`` alone: commands by what they are for, and an example of each."""

import click

EXAMPLES = {
    "Make a scene of photos": {
        "photos": "photos holiday/montmartre --target montmartre",
    },
    "See and use a trained scene": {
        "relight": "relight --model R --view A --sun 45 150 --output noon.png",
        "view": "view results/mine/r3gw_plus/seed0",
        "page": "page results/mine/r3gw_plus/seed0 --target mine.html",
        "export": "export --model R --light-of A --target exported",
    },
    "Check and compare": {
        "doctor": "doctor --config config/photos.yaml",
        "mask-sheet": "mask-sheet --name mine --scene S --masks K --target figures",
        "score": "score --renders theirs --truth S/images --output scores.csv",
    },
    "Stages of the workflow: data": {
        "generate": """generate --settings '{"building": "chapel"}' --target chapel""",
        "import": """import --scene mine --entry '{"format": "photos"}' --source photos """
        "--target S",
        "masks": "masks --scene S --sources '{}' --target K",
        "initialise": "initialise --scene S --sky '{}' --masks K --target initial.npz",
    },
    "Stages of the workflow: runs": {
        "train": "train --scene S --masks K --initial initial.npz --settings settings.json "
        "--name mine --variant full --target R",
        "evaluate": "evaluate --scene S --masks K --model M --target R/metrics",
    },
    "Stages of the workflow: checks": {
        "doctor-sources": """doctor-sources --entries '{"mine": {"format": "photos"}}'""",
        "doctor-scene": "doctor-scene --scene mine --results results --target checked.json",
        "doctor-run": "doctor-run --name mine/full/0 --checked checked.json "
        "--settings settings.json",
    },
    "Stages of the workflow: tables and pictures": {
        "tables": "tables --kind table1 --target results R/metrics/metrics.json",
        "study": "study --baseline full --target study.csv --runs runs.csv --figure study.png "
        "R/metrics/metrics.json",
        "figures": "figures --name mine --scene S --masks K --target figures R",
        "report": "report --results results --scene mine --variant full --target report.html",
    },
}
LETTERS = (
    "In the examples M is a run's model.safetensors, R its folder, S the folder of the imported "
    "scene, K that of its masks, and A the name of a photo."
)


class OverviewGroup(click.Group):
    """A group whose help lists its commands by `EXAMPLES`."""

    def format_commands(
        self,
        ctx: click.Context,  # noqa: ARG002  The signature is click's.
        formatter: click.HelpFormatter,
    ) -> None:
        """Write a list per section: what each command is for, and below it an example."""
        for title, examples in EXAMPLES.items():
            with formatter.section(title):
                for name, example in examples.items():
                    told = self.commands[name].get_short_help_str(formatter.width - 20)
                    formatter.write(f"{'':>{formatter.current_indent}}{name:<16}{told}\n")
                    with formatter.indentation(), formatter.indentation():
                        formatter.write_text(f"r3gw {example}")
        formatter.write_paragraph()
        formatter.write_text(LETTERS)
