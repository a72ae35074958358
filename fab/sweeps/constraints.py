"""Conditions on values by their dotted names, such as "design.columns <= 2 * design.rows"."""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence
from typing import Any

from fab.errors import InvalidJob
from fab.sweeps.dotted_names import named

__all__ = ["Constraint", "constraints_of"]

_FUNCTIONS = {"abs": abs, "min": min, "max": max}
_MOST_LETTERS = 1000
_CURE = 'Write it as in "design.columns <= 2 * design.rows".'


class Constraint:
    """A condition. Its names are keys, in full or by their last parts.

    Attributes
    ----------
    text : as it was given. keys : those that it names.

    >>> constraint = Constraint("rows <= 2 * strips", ["a.rows", "a.strips"])
    >>> constraint.holds({"a.rows": 10, "a.strips": 4})
    False
    >>> constraint.excess({"a.rows": 10, "a.strips": 4})
    2.0
    """

    def __init__(self, text: str, keys: Sequence[str], what: str = "axis") -> None:
        from simpleeval import SimpleEval

        self.text = text
        if len(text) > _MOST_LETTERS:
            raise InvalidJob(
                f"constraint {text[:40]!r}... has {len(text)} letters, must have at most "
                f"{_MOST_LETTERS}. Divide it into several."
            )
        try:
            parsed = ast.parse(text, mode="eval").body
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            raise InvalidJob(f"constraint {text!r}: is no condition: {error}. {_CURE}") from error
        flat = _Flat(keys, what, text)
        self._tree: ast.expr = flat.visit(parsed)
        self._names = flat.names
        self._evaluator = SimpleEval(functions=_FUNCTIONS)

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys that it names."""
        return tuple(self._names.values())

    def holds(self, values: Mapping[str, Any]) -> bool:
        """Whether values meet the condition. Raises `InvalidJob` where that cannot be said."""
        return bool(self._value(self._tree, values))

    def excess(self, values: Mapping[str, Any]) -> float:
        """By how much it is missed, 0 or less where it holds; 1 or 0 where it is no inequality.

        Values that are None miss it. Raises `InvalidJob` where that cannot be said.
        """
        if any(values.get(key) is None for key in self.keys):
            return 1.0
        tree = self._tree
        if isinstance(tree, ast.Compare) and len(tree.ops) == 1:
            left, right = (self._value(side, values) for side in (tree.left, tree.comparators[0]))
            try:
                if isinstance(tree.ops[0], ast.LtE | ast.Lt):
                    return float(left - right)
                if isinstance(tree.ops[0], ast.GtE | ast.Gt):
                    return float(right - left)
            except (TypeError, OverflowError) as error:  # of texts, and of numbers without bound
                raise self._refusal(error) from error
        return 0.0 if self.holds(values) else 1.0

    def _value(self, tree: ast.expr, values: Mapping[str, Any]) -> Any:
        self._evaluator.names = {name: values[key] for name, key in self._names.items()}
        try:
            return self._evaluator.eval(self.text, tree)
        except Exception as error:  # simpleeval raises whatever the values give
            raise self._refusal(error) from error

    def _refusal(self, error: Exception) -> InvalidJob:
        said = str(error).rstrip(".") or type(error).__name__
        return InvalidJob(f"constraint {self.text!r}: cannot be evaluated: {said}. {_CURE}")


class _Flat(ast.NodeTransformer):
    """Dotted names as single ones."""

    def __init__(self, keys: Sequence[str], what: str, text: str) -> None:
        self._keys, self._what, self._text = keys, what, text
        self.names: dict[str, str] = {}

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        return self._flat(ast.unparse(node))

    def visit_Name(self, node: ast.Name) -> ast.AST:
        return self._flat(node.id)

    def visit_Call(self, node: ast.Call) -> ast.AST:
        node.args = [self.visit(argument) for argument in node.args]
        return node

    def _flat(self, name: str) -> ast.Name:
        try:
            key = named(name, self._keys, self._what)
        except InvalidJob as error:
            raise InvalidJob(f"constraint {self._text!r}: {error}") from error
        flat = key.replace(".", "__")
        self.names[flat] = key
        return ast.Name(flat, ast.Load())


def constraints_of(
    texts: Sequence[str], keys: Sequence[str], what: str = "axis"
) -> tuple[Constraint, ...]:
    """Conditions on keys. Raises `InvalidJob` for what is no condition, or names another key."""
    return tuple(Constraint(text, keys, what) for text in texts)
