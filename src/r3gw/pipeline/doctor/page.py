"""The doctor's page: Markdown that is as readable on a terminal as in a viewer."""

from collections.abc import Sequence

from r3gw.pipeline.doctor.findings import Findings


def page(sections: Sequence[Findings]) -> str:
    """All findings as Markdown, the verdict first.

    Args:
        sections: What was found, scene by scene.
    """
    problems = sum(len(section.problems) for section in sections)
    warnings = sum(len(section.warnings) for section in sections)
    verdict = "Nothing stands in the way of a run." if not problems else "A run would fail."
    counts = f"{_number(problems, 'problem')}, {_number(warnings, 'warning')}."
    lines = ["# Doctor", "", f"{verdict} {counts}"]
    for section in sections:
        lines += ["", f"## {section.title}", "", *_facts(section)]
        remarks = [f"- **Problem:** {problem}" for problem in section.problems]
        remarks += [f"- Warning: {warning}" for warning in section.warnings]
        lines += ["", *remarks] if remarks else []
        if section.picture is not None:
            lines += ["", f"![Up direction of {section.title}]({section.picture})"]
    return "\n".join(lines) + "\n"


def _facts(section: Findings) -> list[str]:
    width = max((len(label) for label in section.facts), default=0)
    rows = [f"| {label:<{width}} | {value} |" for label, value in section.facts.items()]
    head = [f"| {'':<{width}} | |", f"| {'-' * width} | --- |"]
    return [*head, *rows] if rows else []


def _number(count: int, noun: str) -> str:
    return f"{count} {noun}" + ("" if count == 1 else "s")
