"""The trees of a file: their IDs, the main tree, and the models of subtrees."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from hmrsim.diagnostics import instead, meant, shown

if TYPE_CHECKING:
    from bt_controller.loading.source import Element, Faults

_ROOT_ATTRIBUTES: Final = ("BTCPP_format", "main_tree_to_execute")
_PORTS: Final = ("input_port", "output_port", "inout_port")
_PARTS: Final = ("BehaviorTree", "TreeNodesModel", "include")


@dataclass(frozen=True)
class Document:
    """The trees of a file.

    Attributes:
        trees: The <BehaviorTree> elements by ID.
        main: The ID of the tree to run.
        models: The ports of subtrees by ID, each with its default; None if it has none.
    """

    trees: Mapping[str, Element]
    main: str
    models: Mapping[str, Mapping[str, str | None]]


def document(root: Element, faults: Faults, *, tree: str | None = None) -> Document:
    """Return the trees of a file.

    Args:
        root: The root element.
        faults: Collects the errors; invalid elements are left out.
        tree: The ID of the tree to run; by default the file's main tree.
    """
    if root.tag != "root":
        faults.add(root.origin, 'is no file of trees; <root BTCPP_format="4"> is expected')
    trees, models = _parts(root, faults)
    found = root.findall("BehaviorTree")
    if not found and root.tag == "root":
        faults.add(root.origin, 'has no trees; <BehaviorTree ID="…"> is expected')
    if found:
        _look(root, faults)
    # A tree without an ID is reported already, and may be the main tree.
    known = bool(found) and all(element.attrib.get("ID") for element in found)
    return Document(trees, _main(root, trees, tree, faults) if known else "", models)


def _parts(root: Element, faults: Faults) -> tuple[dict[str, Element], dict[str, dict[str, str | None]]]:
    trees: dict[str, Element] = {}
    models: dict[str, dict[str, str | None]] = {}
    children: list[Any] = list(root)
    for child in children:
        if child.tag == "BehaviorTree":
            _add_tree(child, trees, faults)
        elif child.tag == "TreeNodesModel":
            models |= {model.attrib["ID"]: _model(model) for model in child.findall("SubTree") if "ID" in model.attrib}
        elif root.tag == "root":
            faults.add(child.origin, f"not allowed in <root>{instead(child.tag, _PARTS)}")
    return trees, models


def _add_tree(element: Any, trees: dict[str, Element], faults: Faults) -> None:
    tree_id = element.attrib.get("ID", "")
    for attribute in element.attrib:
        if attribute != "ID" and not attribute.startswith("_"):
            faults.add(element.origin, f"unknown attribute {shown(attribute)}; expected ID")
    if not tree_id:
        faults.add(element.origin, 'has no ID; write ID="…"')
        return
    if len(element) != 1:
        faults.add(element.origin, f"{shown(tree_id)} has {len(element)} children; expected exactly 1")
    if tree_id in trees:
        faults.add(element.origin, f"tree {shown(tree_id)} is already defined at {trees[tree_id].origin}")
    else:
        trees[tree_id] = element


def _model(element: Any) -> dict[str, str | None]:
    return {
        port.attrib["name"]: port.attrib.get("default") or None
        for port in element
        if port.tag in _PORTS and "name" in port.attrib
    }


def _look(root: Element, faults: Faults) -> None:
    """Check the attributes of the root."""
    for attribute in root.attrib:
        if attribute not in _ROOT_ATTRIBUTES and (alike := meant(attribute, _ROOT_ATTRIBUTES)):
            faults.add(root.origin, f"unknown attribute {shown(attribute)}; did you mean {alike!r}?")
    said = root.attrib.get("BTCPP_format")
    if said is None:
        faults.warn(root.origin, 'does not say its format; BTCPP_format="4" is read, and BehaviorTree.CPP wants it')
    elif said != "4":
        faults.add(root.origin, f'is of format {shown(said)}; BTCPP_format="4" is read')


def _main(root: Element, trees: Mapping[str, Element], tree: str | None, faults: Faults) -> str:
    main = root.attrib.get("main_tree_to_execute") if tree is None else tree
    if main is None and len(trees) > 1:
        known = ", ".join(trees)
        faults.add(root.origin, f"names no tree to run; give main_tree_to_execute or --tree, one of {known}")
    elif main is not None and main not in trees:
        faults.add(root.origin, f"unknown tree {shown(main)}{instead(main, trees)}")
    return next(iter(trees)) if main is None else main
