"""The robots of tools/robots.py, and where their files are."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

DATA = "example-robot-data"


@dataclass(frozen=True)
class Robot:
    name: str
    file: str
    """The end of a path among a package's files, or a path."""
    base: str = "fixed"
    """``fixed``, ``floating``, or the base link of an SDF file."""
    what: str = ""
    package: str = DATA


ROBOTS: tuple[Robot, ...] = (
    Robot("double_pendulum", "double_pendulum_description/urdf/double_pendulum.urdf", what="double pendulum"),
    Robot("ur5", "ur_description/urdf/ur5_robot.urdf", what="arm, 6 R"),
    Robot("kinova", "kinova_description/robots/kinova.urdf", what="arm with a hand"),
    Robot("xarm7", "xarm_description/urdf/xarm7.urdf", what="arm, 7 R"),
    Robot("panda", "panda_description/urdf/panda.urdf", what="arm, 7 R, gripper"),
    Robot("iiwa", "models/assets/robots/iiwa/robot.xml", what="arm, 7 R (MJCF)", package="robosuite"),
    Robot("allegro", "allegro_hand_description/urdf/allegro_right_hand.urdf", what="hand"),
    Robot("hyq", "hyq_description/robots/hyq_no_sensors.urdf", "floating", "quadruped"),
    Robot("anymal_b", "anymal_b_simple_description/robots/anymal.urdf", "floating", "quadruped"),
    Robot("anymal_c", "anymal_c_simple_description/urdf/anymal.urdf", "floating", "quadruped"),
    Robot("solo12", "solo_description/robots/solo12.urdf", "floating", "quadruped"),
    Robot("go2", "go2_description/urdf/go2.urdf", "floating", "quadruped"),
    Robot("b1_z1", "b1_description/urdf/b1-z1.urdf", "floating", "quadruped with an arm"),
    Robot("cassie", "cassie_description/robots/cassie_v2.sdf", "pelvis", "biped, its tree"),
    Robot("bolt", "bolt_description/robots/bolt.urdf", "floating", "biped"),
    Robot("g1", "g1_description/urdf/g1_29dof_rev_1_0.urdf", "floating", "humanoid"),
    Robot("icub", "icub_description/robots/icub_reduced.urdf", "floating", "humanoid"),
    Robot("talos", "talos_data/robots/talos_reduced.urdf", "floating", "humanoid"),
    Robot("romeo", "romeo_description/urdf/romeo_small.urdf", "floating", "humanoid"),
    Robot("baxter", "baxter_description/urdf/baxter.urdf", what="two arms"),
    Robot("tiago", "tiago_description/robots/tiago_no_hand.urdf", what="mobile manipulator"),
    Robot("tiago_hand", "tiago_description/robots/tiago.urdf", "floating", "mobile manipulator with a hand"),
    Robot("pr2", "pr2_description/urdf/pr2.urdf", what="mobile manipulator, two arms"),
    Robot("talos_full", "talos_data/robots/talos_full_v2.urdf", "floating", "humanoid, with grippers"),
)


def find_robot(robot: Robot) -> Path:
    """Its file. Raises FileNotFoundError saying which package brings it."""
    if Path(robot.file).exists():
        return Path(robot.file).resolve()
    try:
        installed = distribution(robot.package).files or []
    except PackageNotFoundError:
        raise FileNotFoundError(f"{robot.package} is not installed (pip install {robot.package})") from None
    for file in installed:
        if str(file).endswith(robot.file):
            return Path(str(file.locate())).resolve()
    raise FileNotFoundError(f"{robot.package} has no {robot.file}")
