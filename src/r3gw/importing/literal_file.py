"""Somebody else's Python file read as data: it is parsed, never executed.

Allowed are assignments of literals (numbers, text, True, False, None, lists, tuples, dicts),
pi as ``np.pi``, ``numpy.pi``, ``math.pi`` or ``pi``, the operators + - * / and a sign, and the
imports that name numpy or math. Anything else is refused with its line number.
"""

import ast
import math
from collections.abc import Callable
from pathlib import Path

from r3gw.files import InputError

_MAX_BYTES = 4_000_000
_PI = ("np.pi", "numpy.pi", "math.pi", "pi")
_MODULES = ("numpy", "math")
_OPERATORS: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: lambda left, right: left + right,
    ast.Sub: lambda left, right: left - right,
    ast.Mult: lambda left, right: left * right,
    ast.Div: lambda left, right: left / right,
}


class _Refused(Exception):
    """A construct outside the allowed language."""

    def __init__(self, node: ast.AST, reason: str) -> None:
        self.line = getattr(node, "lineno", 1)
        super().__init__(reason)


def read_literals(path: Path) -> dict[str, object]:
    """The values assigned at the top level of ``path``, by variable name.

    Raises:
        InputError: If the file is missing, is not Python, or holds anything but literals.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    if path.stat().st_size > _MAX_BYTES:
        raise InputError(f"{path}: larger than {_MAX_BYTES} bytes, which is no settings file")
    try:
        tree = ast.parse(path.read_text(encoding="utf-8-sig"))
        assigned: dict[str, object] = {}
        for statement in tree.body:
            assigned.update(_statement(statement))
    except _Refused as refused:
        raise InputError(
            f"{path}: line {refused.line} {refused}; the file is read as data and may hold only "
            "literals, np.pi and + - * /"
        ) from None
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"{path}: not readable as Python literals ({reason})") from None
    return assigned


def _statement(statement: ast.stmt) -> dict[str, object]:
    if isinstance(statement, ast.Import):
        if all(alias.name in _MODULES for alias in statement.names):
            return {}
        raise _Refused(statement, f"imports {statement.names[0].name}")
    if isinstance(statement, ast.ImportFrom):
        if statement.module in _MODULES and [a.name for a in statement.names] == ["pi"]:
            return {}
        raise _Refused(statement, f"imports from {statement.module}")
    if isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant):
        return {}
    if isinstance(statement, ast.AnnAssign) and statement.value is not None:
        return {_target(statement.target): _value(statement.value)}
    if isinstance(statement, ast.Assign) and len(statement.targets) == 1:
        return {_target(statement.targets[0]): _value(statement.value)}
    raise _Refused(statement, f"has a statement that is no assignment ({_kind(statement)})")


def _target(node: ast.expr) -> str:
    if isinstance(node, ast.Name):
        return node.id
    raise _Refused(node, f"assigns to something that is no plain name ({_kind(node)})")


def _value(node: ast.expr) -> object:
    if isinstance(node, ast.Constant) and isinstance(node.value, str | bool | None):
        return node.value
    if isinstance(node, ast.List | ast.Tuple):
        return [_value(element) for element in node.elts]
    if isinstance(node, ast.Dict):
        return {_key(key, node): _value(value) for key, value in _pairs(node)}
    return _number(node)


def _pairs(node: ast.Dict) -> list[tuple[ast.expr | None, ast.expr]]:
    return list(zip(node.keys, node.values, strict=True))


def _key(key: ast.expr | None, parent: ast.Dict) -> object:
    if isinstance(key, ast.Constant) and isinstance(key.value, str | int):
        return key.value
    raise _Refused(key or parent, "has a dict key that is no text or whole number")


def _number(node: ast.expr) -> float:
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        return _finite(node, lambda: float(node.value))  # type: ignore[arg-type]
    if isinstance(node, ast.Name | ast.Attribute) and ast.unparse(node) in _PI:
        return math.pi
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.UAdd):
        operand = _number(node.operand)
        return -operand if isinstance(node.op, ast.USub) else operand
    if isinstance(node, ast.BinOp) and type(node.op) in _OPERATORS:
        left, right = _number(node.left), _number(node.right)
        return _finite(node, lambda: _OPERATORS[type(node.op)](left, right))
    raise _Refused(node, f"has an expression that is no literal ({_kind(node)})")


def _finite(node: ast.expr, compute: Callable[[], float]) -> float:
    try:
        result = compute()
    except (OverflowError, ZeroDivisionError):
        result = math.inf
    if math.isfinite(result):
        return result
    raise _Refused(node, "has a number that is not finite")


def _kind(node: ast.AST) -> str:
    return type(node).__name__
