"""The code of a workflow's stages: the digests that decide whether a stage runs again.

A stage is one command of ``python -m r3gw``. Its code is the function of that command, what the
function uses of its own module, and all that those import. Other commands do not count, although
they stand beside it and the command line registers them all.
"""

import ast
import hashlib
from dataclasses import dataclass
from pathlib import Path

from r3gw.files.imports import Imports, statements
from r3gw.native.code import PACKAGE, code_digest


@dataclass(frozen=True)
class Command:
    """One command of the command line.

    Attributes:
        text: Source of its function and of what that uses of its module.
        modules: Names of the modules that this imports.
    """

    text: str
    modules: tuple[str, ...]


class StageCode:
    """The code of all stages, read once: for one process, in which no source changes."""

    def __init__(self, package: Path = PACKAGE) -> None:
        """Read the command line of the package r3gw in the folder ``package``."""
        self._imports = Imports(package)
        self._commands: dict[str, Command] = {}
        for path in sorted((package / "cli").glob("*.py")):
            self._commands |= _commands(path, self._imports)

    def digest(self, command: str) -> str:
        """Digest of the code of one command.

        Args:
            command: Its name on the command line, such as ``train``.

        Raises:
            InputError: If it needs the compiled extension, and that is missing or out of date.
        """
        own = self._commands[command]
        parts = f"{own.text}\n{code_digest(own.modules, self._imports)}"
        return hashlib.sha256(parts.encode()).hexdigest()[:16]

    def modules(self, command: str) -> frozenset[str]:
        """Names of all modules that a command can reach."""
        return self._imports.reached(self._commands[command].modules)


def _commands(path: Path, imports: Imports) -> dict[str, Command]:
    """The commands that a module of the command line defines, by name."""
    source = path.read_text(encoding="utf-8")
    tree = ast.parse(source)
    module = f"{imports.package.name}.cli.{path.stem}"
    found = {}
    for node in tree.body:
        if isinstance(node, ast.FunctionDef) and (name := _command_name(node)) is not None:
            used = _used(node, tree)
            modules = [
                imported
                for statement in used
                for inner in statements(statement)
                for imported in imports.imported_by(inner, module)
            ]
            text = "\n".join(_text(statement, source) for statement in used)
            found[name] = Command(text, (module.rpartition(".")[0], *modules))
    return found


def _command_name(function: ast.FunctionDef) -> str | None:
    """The command that a function defines: ``@cli.command("name")``, or its own name."""
    for decorator in function.decorator_list:
        if isinstance(decorator, ast.Call) and ast.unparse(decorator.func) == "cli.command":
            given = [each.value for each in decorator.args if isinstance(each, ast.Constant)]
            return str(given[0]) if given else function.name.replace("_", "-")
    return None


def _used(function: ast.FunctionDef, tree: ast.Module) -> list[ast.stmt]:
    """The top-level statements of a module that a function needs, in their order."""
    chosen: list[ast.stmt] = [function]
    for statement in chosen:
        names = {node.id for node in ast.walk(statement) if isinstance(node, ast.Name)}
        chosen += [each for each in tree.body if each not in chosen and _bound(each) & names]
    return [each for each in tree.body if each in chosen]


def _bound(statement: ast.stmt) -> set[str]:
    """Names that a top-level statement defines."""
    if isinstance(statement, ast.FunctionDef | ast.ClassDef):
        return {statement.name}
    if isinstance(statement, ast.Import | ast.ImportFrom):
        return {(alias.asname or alias.name).split(".")[0] for alias in statement.names}
    names = (node for node in ast.walk(statement) if isinstance(node, ast.Name))
    return {node.id for node in names if isinstance(node.ctx, ast.Store)}


def _text(statement: ast.stmt, source: str) -> str:
    """Source of a statement, its decorators first."""
    nodes = (*getattr(statement, "decorator_list", ()), statement)
    return "\n".join(ast.get_source_segment(source, node) or "" for node in nodes)
