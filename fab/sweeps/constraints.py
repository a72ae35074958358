"""Constraints between axes: conditions such as "design.columns <= 2 * design.rows"."""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence
from typing import Any

from fab.errors import InvalidJob, did_you_mean

__all__ = ["Constraint", "constraints_of"]


class Constraint:
    """A condition on the values of a variation. Its names are the keys of axes.

    >>> constraint = Constraint("a.rows <= 2 * a.strips", ["a.rows", "a.strips"])
    >>> constraint.holds({"a.rows": 10, "a.strips": 4})
    False
    """

    def __init__(self, text: str, keys: Sequence[str]) -> None:
        from simpleeval import SimpleEval

        self.text = text
        try:
            parsed = ast.parse(text, mode="eval").body
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            raise InvalidJob(f"constraint {text!r}: is no condition: {error}") from error
        self._names: dict[str, str] = {}
        self._tree = _Flat(keys, self._names, text).visit(parsed)
        self._evaluator = SimpleEval(functions={"abs": abs, "min": min, "max": max})

    def holds(self, values: Mapping[str, Any]) -> bool:
        """Whether a variation meets the condition. Raises `InvalidJob` where it cannot be told."""
        self._evaluator.names = {name: values[key] for name, key in self._names.items()}
        try:
            return bool(self._evaluator.eval(self.text, self._tree))
        except Exception as error:  # simpleeval raises whatever the values give
            raise InvalidJob(f"constraint {self.text!r}: {error}") from error


class _Flat(ast.NodeTransformer):
    """Dotted keys as single names."""

    def __init__(self, keys: Sequence[str], names: dict[str, str], text: str) -> None:
        self._keys, self._names, self._text = keys, names, text

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        return self._named(ast.unparse(node))

    def visit_Name(self, node: ast.Name) -> ast.AST:
        return self._named(node.id)

    def visit_Call(self, node: ast.Call) -> ast.AST:
        node.args = [self.visit(argument) for argument in node.args]
        return node

    def _named(self, key: str) -> ast.Name:
        if key not in self._keys:
            raise InvalidJob(
                f"constraint {self._text!r}: {key} is no axis.{did_you_mean(key, self._keys)}"
            )
        name = key.replace(".", "__")
        self._names[name] = key
        return ast.Name(name, ast.Load())


def constraints_of(texts: Sequence[str], keys: Sequence[str]) -> tuple[Constraint, ...]:
    """The constraints of a sweep. Raises `InvalidJob` for what is no condition on its axes."""
    return tuple(Constraint(text, keys) for text in texts)
