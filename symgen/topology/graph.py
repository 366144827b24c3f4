"""The graph of a scene: nodes are bodies (node 0 is ground), edges are joints (paper §2)."""

from __future__ import annotations

from itertools import pairwise

import networkx as nx

from symgen.errors import SceneError
from symgen.scene.joints import JOINT_TYPES
from symgen.scene.model import GROUND, Joint, Scene


def cycles(scene: Scene) -> tuple[tuple[str, ...], ...]:
    """An independent set of cycles, each as the joints along it (one per closed loop)."""
    tree, cut = spanning_tree(scene)
    undirected: nx.Graph[str] = nx.Graph()
    for joint in tree:
        undirected.add_edge(joint.parent, joint.child, joint=joint.name)
    found = []
    for joint in cut:
        path = nx.shortest_path(undirected, joint.parent, joint.child)
        edges = [undirected.edges[a, b]["joint"] for a, b in pairwise(path)]
        found.append((*edges, joint.name))
    return tuple(found)


def closure_equations(joint: Joint) -> int:
    """How many equations cutting this joint costs: what it forbids of the six relative motions."""
    return 6 - JOINT_TYPES[joint.type].nv


def spanning_tree(scene: Scene) -> tuple[tuple[Joint, ...], tuple[Joint, ...]]:
    """Split the joints into the spanning tree and the cut joints, both in the scene's order.

    A tree edge enters its child, so of the joints that enter one body all but one are cut. Joints marked
    ``cut`` are cut; otherwise the tree keeps the joints whose closure would cost most equations (the cheapest
    closures are cut), and among equals those that come first in the scene.

    Raises SceneError when the joints marked ``cut`` leave a body without a way to ground.
    """
    order = {joint.name: index for index, joint in enumerate(scene.joints)}
    candidates: dict[tuple[str, str], Joint] = {}

    def keep_cost(joint: Joint) -> tuple[int, int]:
        return (6 - closure_equations(joint), order[joint.name])

    for joint in scene.joints:
        pair = (joint.parent, joint.child)
        if not joint.cut and (pair not in candidates or keep_cost(joint) < keep_cost(candidates[pair])):
            candidates[pair] = joint
    directed: nx.DiGraph[str] = nx.DiGraph()
    directed.add_node(GROUND)
    directed.add_nodes_from(body.name for body in scene.bodies)
    scale = len(scene.joints) + 1
    for (parent, child), joint in candidates.items():
        cost, place = keep_cost(joint)
        directed.add_edge(parent, child, weight=cost * scale + place)
    reached: set[str] = set(nx.descendants(directed, GROUND)) | {GROUND}
    unreached = sorted(set(directed) - reached)
    if unreached:
        forced = ", ".join(f"'{joint.name}'" for joint in scene.joints if joint.cut)
        hint = f" once {forced} is cut" if forced else ""
        raise SceneError(f"body '{unreached[0]}' cannot be reached from ground{hint}", scene.source)
    if directed.number_of_edges() > len(scene.bodies):
        directed = nx.minimum_spanning_arborescence(directed)
    kept = {candidates[edge].name for edge in directed.edges}
    tree = tuple(joint for joint in scene.joints if joint.name in kept)
    cut = tuple(joint for joint in scene.joints if joint.name not in kept)
    return tree, cut
