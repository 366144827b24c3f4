"""The graph of a scene as a drawing: bodies are nodes (node 0 is ground), joints are edges, cut joints dashed."""

from __future__ import annotations

from dataclasses import dataclass

from markupsafe import Markup

from symgen.report.sketch import body_colour
from symgen.report.svg import figure, num, path, tag
from symgen.scene.joints import JOINT_TYPES
from symgen.scene.model import GROUND, Joint, Scene
from symgen.system import System

RADIUS = 17.0
ACROSS, DOWN = 92.0, 74.0
"""In pixels: between branches of a tree that grows to the right, between generations of one that grows down."""
CHARACTER = 6.6
WIDEST = 900.0
"""Trees that would be wider than this grow downwards."""


@dataclass(frozen=True)
class _Layout:
    """Depth and branch of every node; ``flip`` draws from top to bottom."""

    place: dict[str, tuple[float, int]]
    depth: int
    branches: float
    along: float
    """Between a node and its children where the tree grows to the right."""
    across: float
    flip: bool

    def at(self, name: str) -> tuple[float, float]:
        branch, depth = self.place[name]
        along, across = 60 + depth * (self.along if not self.flip else DOWN), 46 + branch * self.across
        return (across + (40 if self.branches == 0 else 0), along - 20) if self.flip else (along, across)

    @property
    def size(self) -> tuple[float, float]:
        if self.flip:
            left, right = (86, 190) if self.branches == 0 else (46, max(176.0, self.across - 40))
            return left + self.branches * self.across + right, 80 + self.depth * DOWN
        return 120 + self.depth * self.along, 92 + self.branches * self.across


def _layout(tree: list[Joint]) -> _Layout:
    children: dict[str, list[str]] = {}
    for joint in tree:
        children.setdefault(joint.parent, []).append(joint.child)
    order, depth = [GROUND], {GROUND: 0}
    for name in order:
        for child in children.get(name, []):
            depth[child] = depth[name] + 1
            order.append(child)
    branch: dict[str, float] = {}
    leaves = 0.0
    stack = [(GROUND, False)]
    while stack:
        name, done = stack.pop()
        own = children.get(name, [])
        if not own:
            branch[name] = leaves
            leaves += 1
        elif done:
            branch[name] = (branch[own[0]] + branch[own[-1]]) / 2
        else:
            stack.append((name, True))
            stack.extend((child, False) for child in reversed(own))
    deepest = max(depth.values())
    place = {name: (branch[name], depth[name]) for name in order}
    longest = max((len(_edge_text(joint, 26)) for joint in tree), default=0)
    along = min(230.0, max(120.0, CHARACTER * longest + 2 * RADIUS + 22))
    flip = deepest * along + 120 > WIDEST
    across = max(210.0, CHARACTER * longest + 60) if flip else ACROSS
    return _Layout(place, deepest, leaves - 1, along, across, flip)


def topology_graph(system: System) -> Markup:
    """The graph; every node has its number in the tree, every edge its joint's name and letter."""
    scene, tree = system.scene, system.tree
    cut = {joint.name for joint in tree.cut_joints}
    layout = _layout([joint for joint in scene.joints if joint.name not in cut])
    number = {name: index for name, (index, _) in tree.frames.items()}
    parts: list[Markup] = []
    labels: list[Markup] = []
    for joint in scene.joints:
        edge, label = _edge(joint, layout, joint.name in cut)
        parts.append(edge)
        labels.append(label)
    for name in layout.place:
        parts.append(_node(name, number.get(name, -1), layout, scene))
    width, height = layout.size
    if cut:
        width, height = (width, height + 56) if not layout.flip else (width + 60, height)
    title = f"Graph of {scene.name}: " + "; ".join(_words(joint, joint.name in cut) for joint in scene.joints)
    return figure([*parts, *labels], width, height, title, class_="graph")


def _words(joint: Joint, cut: bool) -> str:
    return f"{joint.name} from {joint.parent} to {joint.child}" + (", cut" if cut else "")


def _short(name: str, room: int) -> str:
    return name if len(name) <= room else name[: room - 1] + "…"


def _node(name: str, index: int, layout: _Layout, scene: Scene) -> Markup:
    """A numbered disc; a welded body shares its group's number and is drawn small."""
    x, y = layout.at(name)
    welded = any(joint.child == name and joint.type == "fixed" for joint in scene.joints)
    text = "0" if name == GROUND else str(index + 1)
    radius = 11.0 if welded else RADIUS
    disc = tag("circle", cx=x, cy=y, r=radius, stroke=body_colour(index), class_="node")
    digit = tag("text", text, x=x, y=y + 5, text_anchor="middle", class_="digit")
    if layout.flip:
        label = tag("text", _short(name, 24), x=x + radius + 8, y=y + 5)
    else:
        label = tag("text", _short(name, int(layout.along / CHARACTER)), x=x, y=y + radius + 17, text_anchor="middle")
    ground = tag("path", class_="hatch", d=_ground_strokes(x, y, layout.flip)) if name == GROUND else Markup("")
    return tag("g", ground, disc, digit, label)


def _ground_strokes(x: float, y: float, flip: bool) -> str:
    if flip:
        return "".join(path([(x + k - 4, y - RADIUS - 8), (x + k + 3, y - RADIUS - 1)]) for k in range(-16, 17, 8))
    return "".join(path([(x - RADIUS - 9, y + k + 4), (x - RADIUS - 2, y + k - 3)]) for k in range(-16, 17, 8))


def _edge_text(joint: Joint, room: int) -> str:
    letter = JOINT_TYPES[joint.type].letter
    return _short(joint.name, room) + (f" ({letter})" if letter else " (fixed)")


def _edge(joint: Joint, layout: _Layout, cut: bool) -> tuple[Markup, Markup]:
    (x1, y1), (x2, y2) = layout.at(joint.parent), layout.at(joint.child)
    text = _edge_text(joint, 26)
    if cut:
        return _cut_edge(joint, (x1, y1), (x2, y2), layout, text)
    style = "edge fixed" if joint.type == "fixed" else "edge"
    turn = RADIUS + 9  # out of the parent, across, then straight into the child: labels stand beside that last part
    if layout.flip:
        end, along = (x2, y2 - RADIUS - 5), (0.0, 1.0)
        line = [(x1, y1 + RADIUS + 3), (x1, y1 + turn), (x2, y1 + turn), end]
        label = tag("text", text, x=x2 + 9, y=y2 - RADIUS - 10, class_="joint")
    else:
        end, along = (x2 - RADIUS - 5, y2), (1.0, 0.0)
        line = [(x1 + RADIUS + 3, y1), (x1 + turn, y1), (x1 + turn, y2), end]
        label = tag("text", text, x=(x1 + turn + end[0]) / 2, y=y2 - 8, text_anchor="middle", class_="joint")
    return tag("g", tag("path", class_=style, d=path(line)), _head(end, along)), label


def _head(tip: tuple[float, float], along: tuple[float, float]) -> Markup:
    (x, y), (ux, uy) = tip, along
    wings = [(x - 8 * ux - 4 * uy, y - 8 * uy + 4 * ux), (x, y), (x - 8 * ux + 4 * uy, y - 8 * uy - 4 * ux)]
    return tag("path", class_="head", d=path(wings, close=True))


def _cut_edge(
    joint: Joint, start: tuple[float, float], end: tuple[float, float], layout: _Layout, text: str
) -> tuple[Markup, Markup]:
    """A dashed arc that bulges away from the tree."""
    (x1, y1), (x2, y2) = start, end
    bend = 62.0
    middle = ((x1 + x2) / 2 + (bend if layout.flip else 0), max(y1, y2) + (0 if layout.flip else bend))
    curve = f"M{num(x1)} {num(y1)}Q{num(middle[0])} {num(middle[1])} {num(x2)} {num(y2)}"
    label = tag("text", f"{text}, cut", x=middle[0], y=middle[1] - 6, text_anchor="middle", class_="joint cut")
    return tag("path", class_="edge cut", d=curve), label
