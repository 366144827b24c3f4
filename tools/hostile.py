"""Scene and model files that are hostile from the start: bombs, depth, size, references to other files."""

# ruff: noqa: E501  (one file, one row)

from __future__ import annotations

LINKS = '<link name="a"/><link name="b"/><joint name="j" type="revolute"><parent link="a"/><child link="b"/></joint>'
ROBOT = f'<robot name="r">{LINKS}</robot>'
SCENE = """\
name: x
bodies: [{name: b, mass: 1}]
joints: [{name: j, type: prismatic, parent: ground, child: b, axis: [1, 0, 0]}]
"""


def hostile_documents(size: int) -> dict[str, bytes]:
    """Files by name; the long ones have about ``size`` bytes, so that they can be made longer than any limit."""
    texts = {**_models(size), **_scenes(size), **_mujoco(size)}
    return {name: text.encode("utf-8") for name, text in texts.items()}


def _laughs() -> str:
    rows = "".join(f'<!ENTITY l{k} "{f"&l{k - 1};" * 10}">' for k in range(1, 12))
    return f'<!DOCTYPE robot [<!ENTITY l0 "ha">{rows}]><robot name="&l11;"/>'


def _aliases() -> str:
    rows = "".join(f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 10)}]\n" for k in range(1, 12))
    return f"name: x\na0: &a0 [1]\n{rows}"


def _links(n: int) -> str:
    """A chain of revolutes."""
    rows = (
        f'<link name="l{i}"><inertial><origin rpy=".1 .2 {i % 7}.3"/><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'
        f'</link><joint name="j{i}" type="revolute"><parent link="l{i - 1}"/><child link="l{i}"/><axis xyz="1 2 {i}"/></joint>'
        for i in range(1, n)
    )
    return f'<robot name="r"><link name="l0"/>{"".join(rows)}</robot>'


def _models(size: int) -> dict[str, str]:
    return {
        "laughs.urdf": _laughs(),
        "quadratic.urdf": f'<!DOCTYPE r [<!ENTITY a "{"a" * (size // 20)}">]><robot name="{"&a;" * (size // 40)}"/>',
        "external.urdf": '<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]><robot name="&x;"/>',
        "parameter.urdf": '<!DOCTYPE r [<!ENTITY % x SYSTEM "http://127.0.0.1:9/x.dtd"> %x;]><robot/>',
        "dtd.urdf": f'<!DOCTYPE robot SYSTEM "http://127.0.0.1:9/x.dtd"><robot name="r">{LINKS}</robot>',
        "public.urdf": f'<!DOCTYPE robot PUBLIC "x" "file:///dev/zero"><robot name="r">{LINKS}</robot>',
        "include.urdf": '<robot xmlns:xi="http://www.w3.org/2001/XInclude"><xi:include href="/etc/passwd" parse="text"/></robot>',
        "style.urdf": f'<?xml-stylesheet href="file:///etc/passwd"?><robot name="r">{LINKS}</robot>',
        "deep.urdf": "<robot>" + "<link>" * (size // 6),
        "wide.urdf": '<robot name="r">' + "<a/>" * (size // 4) + "</robot>",
        "kinds.urdf": f'<robot name="r">{LINKS}' + "".join(f"<a{k}/>" for k in range(size // 12)) + "</robot>",
        "attributes.urdf": "<robot " + " ".join(f'a{k}=""' for k in range(size // 12)) + "/>",
        "attribute.urdf": f'<robot name="{"r" * size}">{LINKS}</robot>',
        "type.urdf": ROBOT.replace("revolute", "revolute" * (size // 8)),
        "axis.urdf": ROBOT.replace("</joint>", f'<axis xyz="{"1 " * (size // 2)}"/></joint>'),
        "number.urdf": ROBOT.replace("</joint>", f'<axis xyz="{"1" * size} 0 0"/></joint>'),
        "ends.urdf": ROBOT.replace('<parent link="a"/>', f'<parent link="{"a" * size}"/>'),
        "comment.urdf": f'<robot name="r"><!--{"-x" * (size // 2)}--></robot>',
        "cdata.urdf": f'<robot name="r"><![CDATA[{"<" * size}]]>{LINKS}</robot>',
        "space.urdf": " " * size + "<robot/>",
        "links.urdf": _links(max(3, size // 280)),
        "star.urdf": '<robot name="r"><link name="l0"/>' + "".join(f'<link name="l{k}"/>' for k in range(size // 20)) + "</robot>",
        "loop.urdf": f'<robot name="r">{LINKS}<joint name="k" type="fixed"><parent link="b"/><child link="a"/></joint></robot>',
        "empty.urdf": "",
    }  # fmt: skip


def _scenes(size: int) -> dict[str, str]:
    return {
        "aliases.yaml": _aliases(),
        "recursive.yaml": "&a [*a]\n",
        "deep.yaml": "name: " + "[" * size,
        "deepmap.yaml": "{a: " * (size // 4),
        "dashes.yaml": "- " * (size // 2),
        "questions.yaml": "? " * (size // 2),
        "lists.yaml": "name: x\nbodies: [" + "[]," * (size // 3) + "]",
        "maps.yaml": "name: x\nbodies: [" + "{a: }," * (size // 6) + "]",
        "numbers.yaml": "name: x\ngravity: [" + "1," * (size // 2) + "]",
        "keys.yaml": "".join(f"k{k}: 1\n" for k in range(size // 8)),
        "key.yaml": "k" * size + ": 1",
        "quotedkey.yaml": '"' + "k" * size + '": 1',
        "text.yaml": "name: " + "k" * size,
        "number.yaml": "name: x\ngravity: [" + "1" * size + ", 0, 0]",
        "block.yaml": "name: |\n" + "  k\n" * (size // 4),
        "comments.yaml": "#\n" * (size // 2),
        "documents.yaml": "---\n" * (size // 4),
        "python.yaml": "name: !!python/object/apply:os.system ['true']\n",
        "merge.yaml": "name: x\n<<: {name: y}\n",
        "type.yaml": SCENE.replace("prismatic", "p" * size),
        "parent.yaml": SCENE.replace("ground", "g" * size),
        "parameters.yaml": SCENE + "parameters: [" + ", ".join(["b.mass"] * (size // 8)) + "]",
        "pattern.yaml": SCENE + 'parameters: ["' + "*a" * 200 + 'b"]',
        "outputs.yaml": SCENE + "outputs: [" + ", ".join(f"o{k}" for k in range(size // 8)) + "]",
        "lock.yaml": SCENE + "lock: {" + ", ".join(f"k{k}: 0" for k in range(size // 12)) + "}",
        "model.yaml": "name: x\nmodel: " + "../" * 500 + "dev/zero\n",
        "modelself.yaml": "name: x\nmodel: modelself.yaml\n",
        "modelzero.yaml": "name: x\nmodel: /dev/zero\n",
        "empty.yaml": "",
        "bom.yaml": "\ufeff",
    }  # fmt: skip


def _mujoco(size: int) -> dict[str, str]:
    return {
        "nothing.xml": "<mujoco/>",
        "laughs.xml": _laughs().replace("robot", "mujoco"),
        "include.xml": '<mujoco><include file="/etc/passwd"/></mujoco>',
        "self.xml": '<mujoco><include file="input.xml"/></mujoco>',
        "deep.xml": "<mujoco><worldbody>" + "<body>" * (size // 6),
        "bodies.xml": "<mujoco><worldbody>" + "<body/>" * (size // 7) + "</worldbody></mujoco>",
        "huge.xml": '<mujoco><size memory="1000T"/><worldbody><body><freejoint/></body></worldbody></mujoco>',
        "name.xml": f'<mujoco model="{"m" * size}"><worldbody/></mujoco>',
        "replicate.xml": '<mujoco><worldbody><replicate count="1000000000"><body><geom size="1"/></body></replicate></worldbody></mujoco>',
        "composite.xml": '<mujoco><worldbody><body><composite type="cable" count="100000000 1 1"/></body></worldbody></mujoco>',
        "mesh.xml": '<mujoco><asset><mesh file="/dev/zero"/></asset><worldbody/></mujoco>',
        "plugin.xml": '<mujoco><extension><plugin plugin="x"/></extension><worldbody/></mujoco>',
    }  # fmt: skip
