#!/usr/bin/env bash
# Makes the virtual environment .venv with the versions of requirements/lock.txt and symgen itself, editable.
# Run by the Makefile; remakes the environment only when the lock file changed. PYTHON=… picks the interpreter.
set -euo pipefail
cd "$(dirname "$0")/.."
venv=.venv
packages=() # what Debian and Ubuntu call what is missing

say() { printf 'symgen: %s\n' "$*" >&2; }

find_python() { # sets $python
  local candidate
  for candidate in ${PYTHON:-python3 python3.13 python3.12 python3.11}; do
    if "$candidate" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' 2>/dev/null; then
      python=$candidate
      return
    fi
  done
  python=
}

check_python() {
  find_python
  if [ -z "$python" ]; then
    local found
    found=$("${PYTHON:-python3}" --version 2>/dev/null || echo none)
    say "the locked versions need Python 3.11, 3.12 or 3.13 (make PYTHON=/path/to/python3 picks one); found: $found"
    packages+=(python3 python3-venv)
  elif ! "$python" -c 'import venv, ensurepip' 2>/dev/null; then
    say "$python has no venv module"
    packages+=("$("$python" -c 'import sys; print("python%d.%d-venv" % sys.version_info[:2])')")
  fi
}

check_compiler() { # sets $cc
  local scratch
  if ! cc=$(command -v "${CC:-cc}" || command -v gcc || command -v clang); then
    say "no C compiler"
    packages+=(gcc libc6-dev)
    return
  fi
  scratch=$(mktemp -d)
  printf '#include <math.h>\n#include <stddef.h>\nint main(void) { return 0; }\n' >"$scratch/t.c"
  if ! "$cc" -o "$scratch/t" "$scratch/t.c" -lm 2>/dev/null; then
    say "$cc cannot compile a small C program: are the C library's headers there?"
    packages+=(libc6-dev)
  fi
  rm -rf "$scratch"
}

# Exudyn's module is linked with OpenGL for its viewer, which nothing here opens. Where the machine has no libGL, a
# stand-in beside the libraries of Exudyn's own lets it load; a call of it would abort.
stand_in_for_gl() {
  local site
  site=$($venv/bin/python -c 'import sysconfig; print(sysconfig.get_paths()["platlib"])')
  [ -d "$site/exudyn.libs" ] && [ ! -e "$site/exudyn.libs/libGL.so.1" ] || return 0
  "$venv/bin/python" -c 'import ctypes; ctypes.CDLL("libGL.so.1")' 2>/dev/null && return
  say "no libGL here: Exudyn gets a stand-in, its viewer is not used"
  {
    echo '#include <stdlib.h>'
    nm -D --undefined-only "$site"/exudyn/*.so | sed -n 's/.* \(gl[A-Z][A-Za-z0-9]*\)$/void \1(void) { abort(); }/p' | sort -u
  } | "$cc" -x c -shared -fPIC -Wl,-soname,libGL.so.1 -o "$site/exudyn.libs/libGL.so.1" -
}

check_python
check_compiler
if [ ${#packages[@]} -gt 0 ]; then
  say "on Debian or Ubuntu: sudo apt-get install ${packages[*]}"
  exit 1
fi

key=$({ cat requirements/lock.txt; "$python" -c 'import sys; print(sys.version)'; pwd; } | cksum)
pip="$venv/bin/python -m pip --disable-pip-version-check install --quiet"
if [ "$(cat $venv/lock-key 2>/dev/null)" != "$key" ]; then
  say "making $venv with $("$python" --version) and the versions of requirements/lock.txt (900 MB, one to three minutes)"
  rm -rf $venv
  "$python" -m venv $venv
  $pip -r requirements/lock.txt || {
    say "the packages of requirements/lock.txt could not be installed: is a Python package index reachable?"
    exit 1
  }
  printf '%s\n' "$key" >$venv/lock-key
fi
stand_in_for_gl
# No isolation: the build backend is locked like everything else.
$pip --no-deps --no-build-isolation -e .
touch $venv/stamp
