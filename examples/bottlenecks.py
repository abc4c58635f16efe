"""Ask networkx about the graph of a world: what is the only way, and what would one more lane change?

It needs no simulator: run ``python examples/bottlenecks.py``. World files of your own work as ``hospital`` does.
"""

import networkx as nx

from hmrsim import load_world
from hmrsim.topology import bottlenecks, concentration


def main(name: str = "hospital") -> None:
    """Print the worst bottleneck and the busiest lane, with and without a second door between two rooms."""
    graph = load_world(name).world.graph
    print(graph, "at", graph.graph["speed"], f"{graph.graph['units']}/s")

    way = nx.shortest_path(graph, "pharmacy_counter", "ward_a_aisle", weight="cost")
    print("from the pharmacy to ward A:", " ".join(way), f"in {nx.path_weight(graph, way, 'cost'):.1f} s")
    tell("as it is", graph)

    # The graph of a world is frozen; what would be is asked of a copy.
    changed = graph.copy()
    lane = graph.edges["hall_lab", "lab_door"]
    for ends in (("lab_bench", "ward_a_aisle"), ("ward_a_aisle", "lab_bench")):
        changed.add_edge(*ends, **{**lane, "length": 10.0, "doors": ()})
    tell("with a door between lab and ward A", changed)


def tell(title: str, graph: nx.DiGraph) -> None:
    """Print what takes the graph apart, and where traffic of 0.9 m/s concentrates."""
    found = bottlenecks(graph)
    worst = found.worst[0]
    sides = " | ".join(f"{side.waypoints} waypoints, {len(side.places)} places" for side in worst.sides)
    lane, share = next(iter(concentration(graph, 0.9).shares.items()))
    print(f"{title}: {found.waypoints} waypoints and {found.lanes} lanes are the only way somewhere")
    print(f"  worst is {worst.kind} {' - '.join(worst.name)}, between {sides}")
    print(f"  {share:.0%} of trips take {' - '.join(lane)}")


if __name__ == "__main__":
    main()
