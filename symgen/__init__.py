"""Equations of motion of multibody systems, as certified C and CasADi functions."""

from symgen.scene.load import load

__all__ = ["load"]
