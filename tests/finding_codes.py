"""Codes of findings as the source gives them, read from its syntax: no line of it is run.

The code of a `Finding` is followed to where it is written: through names, tuples that are unpacked,
loops over tables, f-strings, and parameters of functions and fields of dataclasses, whose callers
are looked up in all modules. Whatever cannot be followed is an error, so that none is overlooked.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from itertools import product
from pathlib import Path

from helpers import ROOT

Scope = list[ast.AST]


class Codes:
    """The codes that the modules under a folder give, with the places where they do."""

    def __init__(self, sources: dict[str, str]) -> None:
        self.trees = {name: ast.parse(source) for name, source in sources.items()}
        self.calls = {name: list(_calls(tree, [tree])) for name, tree in self.trees.items()}

    @classmethod
    def of_folder(cls, folder: Path) -> Codes:
        paths = {str(p.relative_to(ROOT)): p for p in sorted(folder.rglob("*.py"))}
        sources = {name: path.read_text("utf-8") for name, path in paths.items()}
        # findings, or functions that make them, are in these; others import from them
        making = {name for name, source in sources.items() if "Finding" in source}
        imported = [f"from {_dotted(name)} import" for name in sorted(making)]
        return cls(
            {
                name: source
                for name, source in sources.items()
                if name in making or any(words in source for words in imported)
            }
        )

    def found(self) -> dict[str, set[str]]:
        """The places of each code."""
        out: dict[str, set[str]] = {}
        for name, calls in self.calls.items():
            for call, scope in calls:
                if _name(call.func) == "Finding":
                    place = f"{name}:{call.lineno}"
                    for code in self.texts(_argument(call, 0, "code"), scope, place, ()):
                        out.setdefault(code, set()).add(place)
        return out

    def severities(self) -> dict[str, set[str]]:
        """The severities of codes, of those written in the call of a `Finding`."""
        out: dict[str, set[str]] = {}
        for calls in self.calls.values():
            for call, scope in calls:
                if _name(call.func) != "Finding":
                    continue
                code, severity = _argument(call, 0, "code"), _argument(call, 1, "severity")
                if isinstance(code, ast.Constant):
                    found = self._severities(severity, scope)
                    out.setdefault(code.value, set()).update(found)
        return out

    def _severities(self, node: ast.AST, scope: Scope) -> set[str]:
        if isinstance(node, ast.Name):
            values = [value for value, path in _bindings(node.id, scope) if not path]
            return set().union(*(self._severities(value, scope) for value in values))
        return {
            each.attr.lower()
            for each in ast.walk(node)
            if isinstance(each, ast.Attribute) and _name(each.value) == "Severity"
        }

    def texts(self, node: ast.AST, scope: Scope, place: str, path: tuple[int, ...]) -> set[str]:
        """All texts that an expression may have, or what is at a path of places within it."""
        if path and isinstance(node, ast.Tuple | ast.List):
            return self.texts(node.elts[path[0]], scope, place, path[1:])
        if not path and isinstance(node, ast.Constant) and isinstance(node.value, str):
            return {node.value}
        if isinstance(node, ast.IfExp):
            return self.texts(node.body, scope, place, path) | self.texts(
                node.orelse, scope, place, path
            )
        if not path and isinstance(node, ast.JoinedStr):
            parts = [
                self.texts(
                    part.value if isinstance(part, ast.FormattedValue) else part, scope, place, ()
                )
                for part in node.values
            ]
            return {"".join(words) for words in product(*parts)}
        if isinstance(node, ast.Name):
            bound = _bindings(node.id, scope)
            if bound:
                return set().union(
                    *(self.texts(value, scope, place, inner + path) for value, inner in bound)
                )
            return self._of_parameter(node.id, scope, place)
        if isinstance(node, ast.Attribute) and _name(node.value) == "self":
            return self._of_field(node.attr, scope, place)
        if isinstance(node, _Each):
            return set().union(
                *(
                    self.texts(item, scope, place, path)
                    for item in self._items(node.of, scope, place)
                )
            )
        raise AssertionError(f"{place}: write the code where it can be read: {ast.unparse(node)}")

    def _items(self, node: ast.AST, scope: Scope, place: str) -> Iterator[ast.AST]:
        """What a loop over an expression gives."""
        if isinstance(node, ast.Tuple | ast.List):
            yield from node.elts
        elif isinstance(node, ast.Dict):
            yield from (
                ast.Tuple([key, value]) for key, value in zip(node.keys, node.values, strict=True)
            )
        elif isinstance(node, ast.Call) and _name(node.func) == "items":
            yield from self._items(node.func.value, scope, place)
        elif isinstance(node, ast.Name):
            for value, _ in _bindings(node.id, scope):
                yield from self._items(value, scope, place)
            for call, _ in _calls(scope[-1], scope):
                if isinstance(call.func, ast.Attribute) and _name(call.func.value) == node.id:
                    if call.func.attr == "append":
                        yield call.args[0]
                    if call.func.attr == "setdefault":
                        yield ast.Tuple([call.args[0], call.args[1]])
        else:
            raise AssertionError(
                f"{place}: write codes where they can be read: {ast.unparse(node)}"
            )

    def _of_parameter(self, name: str, scope: Scope, place: str) -> set[str]:
        """What the callers of the function give to a parameter."""
        function = scope[-1]
        assert isinstance(function, ast.FunctionDef), f"{place}: {name} is bound to nothing"
        names = [each.arg for each in (*function.args.posonlyargs, *function.args.args)]
        return self._given(function.name, name, names.index(name), place)

    def _of_field(self, name: str, scope: Scope, place: str) -> set[str]:
        """What the makers of a dataclass give to a field."""
        (owner,) = [each for each in scope if isinstance(each, ast.ClassDef)]
        fields = [_name(each.target) for each in owner.body if isinstance(each, ast.AnnAssign)]
        return self._given(owner.name, name, fields.index(name), place)

    def _given(self, callee: str, name: str, number: int, place: str) -> set[str]:
        found = [
            self.texts(_argument(call, number, name), scope, f"{module}:{call.lineno}", ())
            for module, calls in self.calls.items()
            for call, scope in calls
            if _name(call.func) == callee and _same(module, callee, place, self.trees)
        ]
        assert found, f"{place}: nobody calls {callee}"
        return set().union(*found)


class _Each(ast.expr):
    """One of those that a loop goes through."""

    _fields = ("of",)


def _same(module: str, callee: str, place: str, trees: dict[str, ast.Module]) -> bool:
    """Whether a module means the function of another by a name: its own, or one that it imports."""
    home = place.partition(":")[0]
    if module == home:
        return True
    dotted = _dotted(home)
    return any(
        isinstance(node, ast.ImportFrom)
        and node.module == dotted
        and any(alias.name == callee for alias in node.names)
        for node in ast.walk(trees[module])
    )


def _calls(node: ast.AST, scope: Scope) -> Iterator[tuple[ast.Call, Scope]]:
    """All calls within a node, in their order, and the functions and classes around each."""
    waiting = [(node, scope)]
    while waiting:
        parent, around = waiting.pop()
        if isinstance(parent, ast.Call):
            yield parent, around
        inner = around
        if parent is not node and isinstance(parent, ast.FunctionDef | ast.ClassDef):
            inner = [*around, parent]
        waiting += [(child, inner) for child in [*ast.iter_child_nodes(parent)][::-1]]


def _bindings(name: str, scope: Scope) -> list[tuple[ast.AST, tuple[int, ...]]]:
    """What is bound to a name, and where in it: of the innermost scope that binds it."""
    for level in reversed(scope):
        found = []
        for node in ast.walk(level):
            pairs: list[tuple[ast.AST, ast.AST]] = []
            if isinstance(node, ast.Assign):
                pairs = [(target, node.value) for target in node.targets]
            elif isinstance(node, ast.For | ast.comprehension):
                pairs = [(node.target, _Each(of=node.iter))]
            for target, value in pairs:
                found += [(value, path) for path in _paths(target, name)]
        if found:
            return found
        if isinstance(level, ast.FunctionDef) and name in {each.arg for each in level.args.args}:
            return []
    return []


def _paths(target: ast.AST, name: str) -> Iterator[tuple[int, ...]]:
    """Where a name is in what is assigned to."""
    if isinstance(target, ast.Name) and target.id == name:
        yield ()
    if isinstance(target, ast.Tuple):
        for number, inner in enumerate(target.elts):
            yield from ((number, *path) for path in _paths(inner, name))


def _argument(call: ast.Call, number: int, name: str) -> ast.AST:
    for keyword in call.keywords:
        if keyword.arg == name:
            return keyword.value
    return call.args[number]


def _name(node: ast.AST) -> str:
    return getattr(node, "id", getattr(node, "attr", ""))


def _dotted(name: str) -> str:
    return name.removesuffix(".py").replace("/", ".")
