"""Plan paths for robots in a separate process, with nothing but a Zenoh session and networkx.

Start ``hmrsim run examples/external_planner.yaml`` first, then run ``python examples/external_planner.py [ENDPOINT]``.
The simulator's own planner knows lengths only; this one keeps robots out of the kitchen, where it can.
"""

import json
import math
import sys

import networkx as nx
import zenoh

KEY = "hmrsim/_planner/compute_path_to_pose"
DETOUR = 100.0
"""Meters of detour that the planner prefers to a route through the kitchen."""


def main(endpoint: str = "tcp/127.0.0.1:7447") -> None:
    """Plan on request, until eve has been to the shelf."""
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", json.dumps([endpoint]))
    with zenoh.open(config) as session:
        graph = ways(ask(session, "hmrsim/_world/route_graph"))
        print(f"planning on {len(graph)} waypoints")
        planner = session.declare_queryable(KEY, lambda query: answer(query, graph))
        target = {"position": {"x": 18, "y": 18}}
        ended = ask(session, "hmrsim/eve/navigate_to_pose/_action/execute", {"goal": {"pose": {"pose": target}}})
        print("status", ended["status"], "error_code", ended["result"]["error_code"])
        planner.undeclare()


def ways(geojson: dict) -> nx.DiGraph:
    """Return the graph of the ways: nodes have their ``point``, edges what it ``costs`` to take them."""
    graph = nx.DiGraph()
    for feature in geojson["features"]:
        properties, shape = feature["properties"], feature["geometry"]
        if shape["type"] == "Point":
            graph.add_node(properties["id"], point=shape["coordinates"], name=properties["metadata"]["name"])
    for feature in geojson["features"]:
        properties = feature["properties"]
        if "startid" in properties:
            start, end = properties["startid"], properties["endid"]
            detour = DETOUR if graph.nodes[end]["name"] == "kitchen" else 0.0
            graph.add_edge(start, end, costs=properties["metadata"]["length"] + detour)
    return graph


def answer(query: zenoh.Query, graph: nx.DiGraph) -> None:
    """Answer one request: a goal of ComputePathToPose in, its result out."""
    goal = json.loads(query.payload.to_bytes())
    start, end = (nearest(graph, goal[which]["pose"]["position"]) for which in ("start", "goal"))
    try:
        nodes = nx.shortest_path(graph, start, end, weight="costs")
    except nx.NetworkXNoPath:
        result = {"error_code": 208, "error_msg": "no way leads there"}
    else:
        print("by way of", ", ".join(graph.nodes[node]["name"] for node in nodes))
        points = [graph.nodes[node]["point"] for node in nodes]
        poses = [{"pose": {"position": {"x": x, "y": y}}} for x, y in points]
        result = {"path": {"poses": [*poses, goal["goal"]]}}
    query.reply(KEY, json.dumps(result))


def nearest(graph: nx.DiGraph, position: dict) -> int:
    """Return the waypoint that is nearest to a position."""
    return min(graph, key=lambda node: math.dist(graph.nodes[node]["point"], (position["x"], position["y"])))


def ask(session: zenoh.Session, key: str, request: dict | None = None) -> dict:
    """Return the answer to one request; the simulator holds a result until the goal has ended."""
    payload = None if request is None else json.dumps(request)
    for reply in session.get(key, payload=payload, timeout=60):
        if reply.ok is None:
            raise SystemExit(reply.err.payload.to_string())
        return json.loads(reply.ok.payload.to_bytes())
    raise SystemExit(f"no answer from {key}; start `hmrsim run examples/external_planner.yaml`")


if __name__ == "__main__":
    main(*sys.argv[1:])
