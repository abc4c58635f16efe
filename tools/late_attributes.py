"""Finds attributes that objects are given after their construction: ``python -m tools.late_attributes``.

A constructor is to get all that its object needs. So a class may not declare a function that others are to set, and
code must not set a function of another object: neither one that its class declares, nor one that it begins with.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

_PACKAGES: Final = ("hmrsim", "hmrsim_zenoh", "bt_controller", "hmrsim_gym")

_RECORDS: Final = {"Protocol", "NamedTuple", "BaseModel", "TypedDict", "dataclass"}
"""Marks of a class whose fields are set by its constructor only."""


def main() -> int:
    """Print every place, and return 1 if there is one."""
    trees = {
        path: ast.parse(path.read_text(encoding="utf-8"))
        for package in _PACKAGES
        for path in sorted(Path(package).rglob("*.py"))
    }
    found = list(late(trees))
    for line in found:
        sys.stderr.write(f"{line}\n")
    return 1 if found else 0


def late(trees: dict[Path, ast.Module]) -> Iterator[str]:
    """Yield every place at which a function is set, or is to be set, from outside."""
    functions: set[str] = set()
    for path, tree in trees.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef):
                declared = [] if _is_record(node) else list(_declared(node))
                functions.update(part.id for _, part in declared)
                functions.update(_begun(node))
                own = {target.attr for target in _targets(node) if _is_own(target)}
                for line, part in declared:
                    if part.id not in own:
                        what = f"{node.name}.{part.id}"
                        yield f"{path}:{line}: {what} is to be set by others; have the constructor take it"
    for path, tree in trees.items():
        for target in _targets(tree):
            if target.attr in functions and not _is_own(target):
                yield f"{path}:{target.lineno}: {ast.unparse(target)} is set from outside; give it to the constructor"


def _is_record(node: ast.ClassDef) -> bool:
    words = {
        name.id for part in (*node.bases, *node.decorator_list) for name in ast.walk(part) if isinstance(name, ast.Name)
    }
    return not words.isdisjoint(_RECORDS)


def _declared(node: ast.ClassDef) -> Iterator[tuple[int, ast.Name]]:
    """Yield the functions that a class declares and doesn't have."""
    for part in node.body:
        if not isinstance(part, ast.AnnAssign) or part.value is not None or not isinstance(part.target, ast.Name):
            continue
        if ast.unparse(part.annotation).startswith("Callable"):
            yield part.lineno, part.target


def _begun(node: ast.ClassDef) -> Iterator[str]:
    """Yield the functions that objects begin with: lambdas that stand in for what others set."""
    for part in ast.walk(node):
        targets: Sequence[ast.expr] = ()
        if isinstance(part, ast.Assign):
            targets = part.targets
        elif isinstance(part, ast.AnnAssign):
            targets = [part.target]
        else:
            continue
        if isinstance(part.value, ast.Lambda):
            yield from (target.attr for target in targets if isinstance(target, ast.Attribute) and _is_own(target))


def _targets(tree: ast.AST) -> Iterator[ast.Attribute]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node


def _is_own(target: ast.Attribute) -> bool:
    return isinstance(target.value, ast.Name) and target.value.id in {"self", "cls"}


if __name__ == "__main__":
    sys.exit(main())
