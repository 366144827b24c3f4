"""Motions: compiled functions carried through time, by SciPy's solvers or by the generated steps.

motion = symgen.simulate("pendulum.scene.yaml", [1.0], [0.0], 10.0)
motion.t, motion.q, motion.v, motion.energy
"""

from symgen.simulate.model import Model
from symgen.simulate.motion import Monitors, Motion
from symgen.simulate.motion_data import motion_data
from symgen.simulate.run import METHODS, simulate

__all__ = ["METHODS", "Model", "Monitors", "Motion", "motion_data", "simulate"]
