"""Which modules of a package a module can reach by its imports, read from the sources.

An import counts wherever it stands, in a function too, but not under ``if TYPE_CHECKING``.
Importing a submodule runs the ``__init__`` of every package that it lies in, so those count as
well, without what their functions import when somebody calls them. Imports by a computed name are
not seen.
"""

import ast
from collections.abc import Iterable, Iterator
from functools import cache, lru_cache
from pathlib import Path


class Imports:
    """The modules of one package by name, and what each of them imports of it."""

    def __init__(self, package: Path) -> None:
        """Look at the package in the folder ``package``, whose name is the folder's."""
        self.package = package
        self._imported = cache(self._read)

    def path(self, name: str) -> Path | None:
        """File of a module or of a package's ``__init__``; None if there is no such source."""
        first, *rest = name.split(".")
        if first != self.package.name:
            return None
        base = self.package.joinpath(*rest)
        files = (base / "__init__.py", base.with_name(f"{base.name}.py"))
        return next((path for path in files if path.is_file()), None)

    def reached(self, names: Iterable[str]) -> frozenset[str]:
        """All modules that ``names`` import, directly or not, themselves included.

        Args:
            names: Full names; those that do not begin with this package's name are left out.
        """
        found: set[str] = set()
        pending = list(names)
        while pending:
            name = pending.pop()
            if name in found or name.split(".")[0] != self.package.name:
                continue
            found.add(name)
            if "." in name:
                pending.append(name.rpartition(".")[0])
            pending += self._imported(name)
        return frozenset(found)

    def imported_by(self, statement: ast.stmt, module: str) -> Iterator[str]:
        """Names of modules that an import statement of ``module`` loads."""
        if isinstance(statement, ast.Import):
            yield from (alias.name for alias in statement.names)
        elif isinstance(statement, ast.ImportFrom):
            source = statement.module or ""
            if statement.level:
                parts = module.split(".")
                is_package = (self.path(module) or Path()).name == "__init__.py"
                kept = len(parts) - statement.level + is_package
                source = ".".join([*parts[:kept], *([source] if source else [])])
            yield source
            for alias in statement.names:
                name = f"{source}.{alias.name}"
                if self.path(name) is not None:
                    yield name

    def _read(self, module: str) -> tuple[str, ...]:
        path = self.path(module)
        if path is None:
            return ()
        return tuple(
            name
            for node in _import_statements(path.read_bytes(), path.name == "__init__.py")
            for name in self.imported_by(node, module)
        )


@lru_cache(maxsize=1024)
def _import_statements(source: bytes, is_facade: bool) -> tuple[ast.stmt, ...]:
    """The import statements of a source that count; kept, since few sources change."""
    tree = ast.parse(source)
    found = statements(_outside_functions(tree) if is_facade else tree)
    return tuple(node for node in found if isinstance(node, ast.Import | ast.ImportFrom))


def statements(tree: ast.AST) -> Iterator[ast.stmt]:
    """Every statement of a tree, inner ones too, but none under ``if TYPE_CHECKING``."""
    pending: list[ast.AST] = [tree]
    while pending:
        node = pending.pop()
        if isinstance(node, ast.stmt):
            yield node
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            pending += node.orelse
        else:
            pending += [e for e in ast.iter_child_nodes(node) if not isinstance(e, ast.expr)]


def _outside_functions(tree: ast.Module) -> ast.Module:
    """The statements of a module that run when it is imported."""
    functions = (ast.FunctionDef, ast.AsyncFunctionDef)
    return ast.Module([node for node in tree.body if not isinstance(node, functions)], [])
