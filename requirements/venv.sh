#!/usr/bin/env bash
# Makes the virtual environment .venv with the versions of requirements/lock.txt and symgen itself, editable.
# Run by the Makefile; remakes the environment only when the lock file changed. PYTHON=… picks the interpreter.
set -euo pipefail
cd "$(dirname "$0")/.."
venv=.venv

say() { printf 'symgen: %s\n' "$*" >&2; }
fail() { say "$@"; exit 1; }

find_python() {
  local candidate
  for candidate in ${PYTHON:-python3 python3.13 python3.12 python3.11}; do
    if "$candidate" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' 2>/dev/null; then
      printf '%s' "$candidate"
      return
    fi
  done
  if command -v "${PYTHON:-python3}" >/dev/null; then
    say "found $("${PYTHON:-python3}" --version 2>&1), but the locked versions need Python 3.11, 3.12 or 3.13."
  else
    say "found no Python; Python 3.11, 3.12 or 3.13 is needed."
  fi
  fail "Debian, Ubuntu: sudo apt-get install python3 python3-venv; elsewhere: any Python of those versions, then make PYTHON=/path/to/python3 …"
}

check_compiler() {
  local cc source
  cc=$(command -v "${CC:-cc}" || command -v gcc || command -v clang) ||
    fail "no C compiler found. Debian, Ubuntu: sudo apt-get install gcc libc6-dev"
  source=$(mktemp -d)
  printf '#include <math.h>\n#include <stddef.h>\nint main(void) { return 0; }\n' >"$source/t.c"
  "$cc" -o "$source/t" "$source/t.c" -lm 2>/dev/null || {
    rm -rf "$source"
    fail "$cc cannot compile a small C program: the C library's headers are missing. Debian, Ubuntu: sudo apt-get install libc6-dev"
  }
  rm -rf "$source"
}

check_compiler
python=$(find_python)
"$python" -c 'import venv, ensurepip' 2>/dev/null ||
  fail "$python has no venv module. Debian, Ubuntu: sudo apt-get install python3-venv (or $("$python" -c 'import sys; print("python%d.%d-venv" % sys.version_info[:2])'))"

key=$({ cat requirements/lock.txt; "$python" -c 'import sys; print(sys.version)'; pwd; } | cksum)
if [ "$(cat $venv/lock-key 2>/dev/null)" != "$key" ]; then
  say "making $venv with $("$python" --version) and the versions of requirements/lock.txt (about 900 MB; one to three minutes)"
  rm -rf $venv
  "$python" -m venv $venv
  $venv/bin/python -m pip --disable-pip-version-check install --quiet -r requirements/lock.txt ||
    fail "the packages of requirements/lock.txt could not be installed: is a Python package index reachable?"
  printf '%s\n' "$key" >$venv/lock-key
fi
# No isolation: the build backend is locked like everything else.
$venv/bin/python -m pip --disable-pip-version-check install --quiet --no-deps --no-build-isolation -e .
touch $venv/stamp
