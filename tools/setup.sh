#!/bin/sh
# Builds .venv (again only when pyproject.toml has changed) and sees to the libraries that PDF output needs.
# PYTHON=python3.12 chooses another interpreter, CONSTRAINTS=/dev/null the newest packages.
set -eu
cd "$(dirname "$0")/.."

python=${PYTHON:-python3}
ready=.venv/.ready
pdf_packages="libpango-1.0-0 libpangoft2-1.0-0 libharfbuzz-subset0 fonts-dejavu-core"

install() { # Debian packages, where that needs no password
    if [ "$(id -u)" = 0 ]; then as_root=
    elif sudo -n true 2>/dev/null; then as_root="sudo -n"
    else return 1
    fi
    command -v apt-get >/dev/null || return 1
    echo "installing $*" >&2
    patience="-o Acquire::Retries=1 -o Acquire::http::Timeout=30 -o Acquire::https::Timeout=30"
    # shellcheck disable=SC2086  # the options are meant to be split
    { [ -n "${updated:-}" ] || $as_root apt-get -q $patience update >&2; } && updated=yes &&
        $as_root env DEBIAN_FRONTEND=noninteractive apt-get -qy $patience install --no-install-recommends "$@" >&2
}

make_venv() { "$python" -m venv --clear .venv; }

pdf_ready() {
    .venv/bin/python - <<'END'
import ctypes, pathlib, sys

for library in ("libpango-1.0.so.0", "libpangoft2-1.0.so.0", "libharfbuzz-subset.so.0"):
    try:
        ctypes.CDLL(library)
    except OSError:
        sys.exit(1)
home = pathlib.Path.home()
folders = (pathlib.Path("/usr/share/fonts"), pathlib.Path("/usr/local/share/fonts"),
           home / ".fonts", home / ".local/share/fonts")
sys.exit(not any(True for folder in folders for _ in folder.rglob("*.[to]tf")))
END
}

libraries() {
    # shellcheck disable=SC2086  # the list is meant to be split
    if ! pdf_ready && ! { install $pdf_packages && pdf_ready; }; then
        echo "setup: the report will be HTML only; for PDF run this, then make again:" >&2
        echo "    sudo apt-get install $pdf_packages" >&2
    fi

    # in CI the page is tested in a browser where one can be had; elsewhere those tests say why they are skipped
    if [ -n "${CI:-}" ] && ! command -v chromium >/dev/null && ! install chromium; then
        echo "setup: no Chromium could be installed: the tests of the page in a browser are skipped" >&2
    fi
}

if ! [ "$ready" -nt pyproject.toml ] || ! [ "$ready" -nt constraints.txt ] || ! .venv/bin/python -c "" 2>/dev/null; then
    "$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || {
        echo "setup: $python is missing or older than Python 3.11; try: make PYTHON=python3.12" >&2
        exit 1
    }
    if ! .venv/bin/python -m pip --version >/dev/null 2>&1; then
        make_venv >/dev/null 2>&1 || { install python3-venv && make_venv; } || {
            echo "setup: Python cannot make an environment; run this, then make again:" >&2
            echo "    sudo apt-get install python3-venv" >&2
            exit 1
        }
    fi
    echo "installing the Python packages into .venv" >&2
    libraries &
    pip() { .venv/bin/python -m pip install --quiet --disable-pip-version-check "$@" -e '.[dev,docs]'; }
    pip -c "${CONSTRAINTS:-constraints.txt}" || {
        echo "setup: the versions of constraints.txt are not all to be had here: the newest instead" >&2
        pip
    }
    wait
    touch "$ready"
else
    libraries
fi
