#!/usr/bin/env bash
# Rewrites requirements/lock.txt with the newest versions that pyproject.toml allows. Run through `make lock`.
set -euo pipefail
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"${PYTHON:-python3}" -m venv "$work/venv"
"$work/venv/bin/python" -m pip --disable-pip-version-check install --quiet '.[all]'
{
  sed -n '/^#/p' requirements/lock.txt
  # Pinocchio and what comes with it has no Windows wheel.
  "$work/venv/bin/python" -m pip --disable-pip-version-check freeze --exclude symgen |
    sed -E "s/^((lib)?(pin|pinocchio|coal)|cmeel.*|eigenpy|example-robot-data|jrl-cmakemodules)==(.*)/&; platform_system != 'Windows'/"
} >"$work/lock.txt"
mv "$work/lock.txt" requirements/lock.txt
