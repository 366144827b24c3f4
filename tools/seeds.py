"""Small good files that hold everything a reader knows: what fuzzing starts from."""

# ruff: noqa: E501  (files as they are)

from __future__ import annotations

SCENE = """\
name: good
gravity: [0, 0, -9.81]
bodies:
  - {name: link1, mass: 1.2, com: [0.1, 0, 0], inertia: [0.1, 0.2, 0.25, 0, 0, 0], basic_points: [[0, 0, 1]]}
  - name: link2
    mass: 0.8
    inertia: {ixx: 0.01, iyy: 0.02, izz: 0.02}
    unit_vectors: [[0, 0, 1]]
  - {name: link3, mass: 1, inertia: [1, 1, 1, 0, 0, 0]}
  - {name: link4, mass: 1}
joints:
  - {name: j1, type: revolute, parent: ground, child: link1, axis: [0, 0, 1], origin: {xyz: [0, 0, 0.3], rpy: [0, 0, 1.57]}}
  - name: j2
    type: universal
    parent: link1
    child: link2
    axis: [1, 0, 0]
    axis2: [0, 1, 0]
    damping: 0.1
    armature: 1e-3
    limits: {lower: -1, upper: 1.5}
  - {name: j3, type: helical, pitch: 0.01, parent: link1, child: link3, axis: [1, 2, 2]}
  - {name: j4, type: prismatic, parent: link2, child: link4, axis: [0, 0, 1], mimic: {joint: j1, multiplier: -2, offset: 0.1}}
forces:
  - {type: spring, name: s, between: [link1, ground], points: [[0, 0, 0], [1, 0, 0]], stiffness: 10, length: 0.5}
  - {type: joint_spring, joint: j1, stiffness: 2, rest: 0}
frames:
  - {name: tool, body: link2, origin: {xyz: [0, 0, 1]}}
parameters: [link1.mass, gravity, s.length, j2.rpy, "link[34].*", "*.offset"]
outputs: [mass_matrix, "frame_pose:tool", {name: both, of: [bias_force, kinetic_energy]}]
options: {base_velocity: world, precision: double, snap: 1e-6, status: true, batch: true, targets: [c]}
"""

OVER = """\
name: over
model: robot.urdf
base: floating
remove: [hand]
lock: {turn: 0.02}
bodies:
  - {name: payload, mass: 3, com: [0, 0, 0.1]}
joints:
  - {name: grasp, type: revolute, parent: arm 1, child: payload, axis: [0, 1, 0], origin: {xyz: [0, 0, 0.08]}}
frames:
  - {name: tcp, body: payload, origin: {xyz: [0, 0, 0.1]}}
parameters: ["payload.*", "arm ?.mass"]
outputs: [mass_matrix, forward_dynamics, "frame_pose:tcp"]
"""

ROBOT = """\
<?xml version="1.0"?>
<robot name="two">
  <material name="blue"/>
  <link name="base"/>
  <link name="arm 1">
    <inertial>
      <origin xyz="0.1 0 0" rpy="0 0 1.5707963267948966"/>
      <mass value="2"/>
      <inertia ixx="0.1" iyy="0.2" izz="0.25" ixy="0.01" ixz="0" iyz="0"/>
    </inertial>
    <visual><geometry><mesh filename="package://x/y.stl"/></geometry></visual>
    <collision/>
  </link>
  <link name="slider"><inertial><mass value="1e-1"/><inertia ixx="1e-3" iyy="1e-3" izz="1e-3"/></inertial></link>
  <joint name="turn" type="revolute">
    <parent link="base"/><child link="arm 1"/>
    <origin xyz="0 0 0.5" rpy="0 0 0"/>
    <axis xyz="0 0 2"/>
    <limit lower="-1" upper="1" effort="5" velocity="2"/>
    <dynamics damping="0.5" friction="0.1"/>
  </joint>
  <joint name="slide" type="prismatic">
    <parent link="arm 1"/><child link="slider"/>
    <mimic joint="turn"/>
  </joint>
  <transmission name="t"/>
</robot>
"""
RICHER = {
    '<?xml version="1.0"?>': '<?xml version="1.0" encoding="utf-8"?>\n<!-- a comment -->',
    'name="two"': 'name="two arms"',
    '<material name="blue"/>': '<material name="blue"><color rgba="0 0 1 1"/></material>',
    '  <joint name="turn"': '  <link name="hand"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>\n  <joint name="turn"',
    'xyz="0 0 0.5" rpy="0 0 0"': 'xyz="0 0 0.5" rpy="0.1 -0.2 0.3"',
    '\n    <mimic joint="turn"/>': '<mimic joint="turn" multiplier="2" offset="0.5"/>',
    "  <transmission": '  <joint name="weld" type="fixed"><parent link="arm 1"/><child link="hand"/></joint>\n  <transmission',
}


def richer(text: str) -> str:
    """The robot with what a reader may stumble over besides."""
    for plain, more in RICHER.items():
        text = text.replace(plain, more, 1)
    return text


MODEL = richer(ROBOT)

MUJOCO = """\
<mujoco model="two">
  <compiler angle="radian" autolimits="true"/>
  <option gravity="0 0 -9.81" timestep="0.002"/>
  <default><joint damping="0.1"/><default class="a"><joint armature="0.01"/></default></default>
  <worldbody>
    <body name="base" pos="0 0 1">
      <freejoint name="root"/>
      <inertial pos="0 0 0.1" mass="2" diaginertia="0.1 0.2 0.25"/>
      <body name="arm" pos="0.1 0 0" euler="0 0 0.5">
        <joint name="h" class="a" type="hinge" axis="0 1 0" pos="0 0 0.1" ref="0.1" range="-1 1" stiffness="2" springref="0.1"/>
        <joint name="s" type="slide" axis="1 0 0"/>
        <inertial pos="0 0 0" mass="1" fullinertia="0.1 0.1 0.1 0.01 0 0"/>
        <site name="tip" pos="0 0 1"/>
        <body quat="1 0 0.1 0"><joint type="ball"/><geom type="sphere" size="0.1" density="1000"/></body>
      </body>
    </body>
  </worldbody>
  <actuator><motor joint="h"/></actuator>
</mujoco>
"""

SEEDS = {"good.scene.yaml": SCENE, "over.scene.yaml": OVER, "good.urdf": MODEL, "good.xml": MUJOCO}
"""By file name. ``over.scene.yaml`` names ``robot.urdf``, which is the good one."""
